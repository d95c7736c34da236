// The hash of a file that nobody writes to.
// SPDX-License-Identifier: MIT
#include "tool/corpus/trace_identity.h"

#include <optional>

#include "verifier/store/mapped_libraries.h"

namespace ticktrue::tool {

Error changed_trace_error(const std::string& file) {
  return Error{ErrorCode::io, file + ": changed while it was read", "verify it again when nothing writes to it"};
}

Result<TraceIdentity> identify_trace(const std::string& file, verifier::StatIndex& index, bool reads) {
  const std::optional<replay::FileFacts> before = replay::file_facts(file);
  if (before && !reads)
    if (const std::optional<Hash128> hash = index.find(file, *before)) return TraceIdentity{*before, *hash};
  const Result<Hash128> read = verifier::file_hash(file);
  if (!read) return read.error();
  const std::optional<replay::FileFacts> after = replay::file_facts(file);
  if (!before || !after) return Error{ErrorCode::io, file + ": cannot be read", ""};
  if (!verifier::is_unchanged(*before, *after)) return changed_trace_error(file);
  index.note(file, *before, *read);
  return TraceIdentity{*before, *read};
}

}  // namespace ticktrue::tool
