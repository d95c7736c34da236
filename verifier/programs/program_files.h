// The files that a command runs, as far as its words and the dynamic linker tell.
// SPDX-License-Identifier: MIT
//
// Not found: libraries that a program loads while it runs, programs that it starts, and files that it reads. The first
// two are told by the session at its end (ProgramRun::mapped); `more` names what is left.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

struct ProgramFile {
  std::string name;  // what counts beside its bytes: a library counts by its name without the folder
  std::string path;  // absolute, without links
};

/// The program, every regular file that another word names (also behind a '='), the files `more` (a folder: all files
/// in it), and the shared libraries that the dynamic linker loads for each of these that is a program. Nothing of them
/// runs but the dynamic linker. Errors: io (a file of `more`, the program or a library of it is not there), limit,
/// unsupported (a system without ELF).
Result<std::vector<ProgramFile>> program_files(const std::vector<std::string>& words,
                                               const std::vector<std::string>& more);

}  // namespace ticktrue::verifier
