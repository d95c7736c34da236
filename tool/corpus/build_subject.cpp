// The subject of a verdict: the digest of the engine, the libraries of the process, and what is chosen at run time.
// SPDX-License-Identifier: MIT
#include "tool/corpus/build_subject.h"

#include <optional>
#include <vector>

#include "base/row_kernels.h"
#include "engine/engine.h"
#include "tool/corpus/engine_digest.h"
#include "tool/session/simulations.h"
#include "verifier/store/mapped_libraries.h"

namespace ticktrue::tool {

std::string_view mode_name(verifier::VerifyMode mode) {
  for (const verifier::VerifyModeInfo& info : verifier::verify_modes)
    if (info.mode == mode) return info.name;
  return "";
}

std::string part_words(const verifier::TracePart& part) {
  return "part " + std::to_string(part.index + 1) + " of " + std::to_string(part.count);
}

Result<BuildSubject> build_subject(verifier::VerifyMode mode, const ProgramSubject* program) {
  const std::optional<Hash128> engine = program == nullptr ? engine_digest() : program_verification_digest();
  if (!engine)
    return Error{ErrorCode::unsupported, "this build does not know what it is made of: found no digest of the engine",
                 "build natively with Ninja; or use the command verify, which needs no store"};
  const Result<std::vector<verifier::MappedLibrary>> libraries = verifier::mapped_libraries();
  if (!libraries) return libraries.error();
  BuildSubject subject;
  subject.engine = *engine;
  subject.libraries = libraries_digest(*libraries);
  // What is chosen at run time and is to change no bit: a verdict is that of the code that ran.
  subject.options = "mode " + std::string(mode_name(mode)) + ", kernels " +
                    std::string(engine::info_of(engine::instruction_sets, engine::instruction_set_in_use()).name) +
                    ", rows " + std::to_string(all_row_kernels().size()) + ", checks " +
                    (engine_options_of_environment().check_caches ? "caches" : "nothing");
  if (program == nullptr) return subject;
  ByteWriter out;
  for (const Hash128& digest : {*engine, program->digest()}) {
    out.u64(digest.high);
    out.u64(digest.low);
  }
  subject.engine = hash128(out.view());
  // The program counts with all its bytes; the kernels stand for the processor, by which it may choose as well.
  subject.options += ", command " + program->words_text();
  return subject;
}

}  // namespace ticktrue::tool
