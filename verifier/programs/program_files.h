// The files that a command uses, as far as its words and the dynamic linker name them.
// SPDX-License-Identifier: MIT
//
// Not found: libraries that a program loads while it runs, programs that it starts, and files that it reads. The
// session reports the first two at its end (ProgramRun::mapped). `more` names the others.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

struct ProgramFile {
  std::string name;  // identifies the file besides its bytes; of a library, the name without the folder
  std::string path;  // absolute, with links resolved
};

/// The program; each regular file that another word names (also after a '='); the files `more` (of a folder, all files
/// in it); and the shared libraries that the dynamic linker loads for each program among these files. Nothing but the
/// dynamic linker runs.
/// Errors: io (a file of `more`, the program or one of its libraries is missing), limit, unsupported (a system without
/// ELF).
Result<std::vector<ProgramFile>> program_files(const std::vector<std::string>& words,
                                               const std::vector<std::string>& more);

}  // namespace ticktrue::verifier
