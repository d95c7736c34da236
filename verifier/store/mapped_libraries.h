// The shared libraries that this process runs: a verdict holds for these alone.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/hash128.h"
#include "base/result.h"

namespace ticktrue::verifier {

struct MappedLibrary {
  std::string path;
  Hash128 content;
};

/// Every shared library that is mapped, plug-ins and what they need with them; not the program itself.
/// Errors: io (a library that cannot be read, or whose file was replaced since it was mapped); unsupported.
Result<std::vector<MappedLibrary>> mapped_libraries();

/// Of names without folders, and contents: a library that was moved is the same.
Hash128 libraries_digest(const std::vector<MappedLibrary>& libraries);

/// XXH3-128 of a file of any size. Errors: io (also a file that changes meanwhile).
Result<Hash128> file_hash(const std::string& path);

}  // namespace ticktrue::verifier
