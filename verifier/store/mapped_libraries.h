// The shared libraries of this process. A verdict is valid only for these libraries.
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

/// Each mapped shared library, including plug-ins and their dependencies, without the program itself.
/// Errors: io (a library that cannot be read, or whose file was replaced since it was mapped); unsupported.
Result<std::vector<MappedLibrary>> mapped_libraries();

/// A hash of names without folders, and of contents: moving a library changes nothing.
Hash128 libraries_digest(const std::vector<MappedLibrary>& libraries);

/// XXH3-128 of a file of any size. Errors: io (also if the file changes meanwhile).
Result<Hash128> file_hash(const std::string& path);

}  // namespace ticktrue::verifier
