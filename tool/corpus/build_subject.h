// What a verdict is about: a build, how it verifies, and a trace or a part of it.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "base/hash128.h"
#include "base/result.h"
#include "tool/corpus/program_subject.h"
#include "tool/corpus/trace_identity.h"
#include "verifier/store/history.h"
#include "verifier/store/verdict_store.h"
#include "verifier/verify/parts.h"
#include "verifier/verify/verify.h"

namespace ticktrue::tool {

/// All of a verdict's subject but the trace.
struct BuildSubject {
  Hash128 engine;
  Hash128 libraries;
  std::string options;
};
/// Of the engine; or of a program, which then is part of `engine`, with how it is run and judged. Errors: unsupported
/// (a build or a system that cannot tell what it is made of); io.
Result<BuildSubject> build_subject(verifier::VerifyMode mode, const ProgramSubject* program = nullptr);

/// The word of --mode.
std::string_view mode_name(verifier::VerifyMode mode);
/// "part 2 of 5".
std::string part_words(const verifier::TracePart& part);

/// Names of what the store has of a trace, for one build.
class UnitNames {
 public:
  UnitNames(const TraceIdentity& identity, const BuildSubject& build)
      : subject_{identity.hash, identity.facts.size, build.engine, build.libraries, build.options} {}
  std::string whole() const { return verdict_key(subject_); }
  std::string part(const verifier::TracePart& part) const { return with(part_words(part)); }
  /// Of the agreement about the number of parts.
  std::string parts() const { return with("parts"); }
  std::string history() const { return verifier::history_name(subject_.trace, subject_.size); }

 private:
  std::string with(const std::string& words) const {
    verifier::VerdictSubject subject = subject_;
    subject.options += ", " + words;
    return verdict_key(subject);
  }
  verifier::VerdictSubject subject_;
};

}  // namespace ticktrue::tool
