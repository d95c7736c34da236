// Files, programs of the system, and what it permits.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/facts.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "verifier/runs/child.h"

namespace ticktrue::shake {
namespace {

namespace fs = std::filesystem;

constexpr double probe_time_s = 30;

verifier::ChildResult probe(std::vector<std::string> words) {
  verifier::ChildCommand command;
  command.argv = std::move(words);
  command.limits.time_s = probe_time_s;
  command.limits.output_size_max = std::size_t{1} << 20;
  return verifier::run_child(command);
}

bool succeeded(const verifier::ChildResult& result) {
  return result.end.how == verifier::ChildEnd::How::exited && result.end.exit_status == 0;
}

std::string beginning_of(const std::string& path, std::size_t size_max) {
  std::ifstream in(path, std::ios::binary);
  std::string text(size_max, '\0');
  in.read(text.data(), static_cast<std::streamsize>(size_max));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

std::string first_existing(const std::vector<std::string>& names) {
  for (const char* folder :
       {"/usr/lib/x86_64-linux-gnu/", "/usr/lib/aarch64-linux-gnu/", "/usr/lib64/", "/usr/lib/", "/usr/local/lib/"})
    for (const std::string& name : names) {
      std::error_code failure;
      if (fs::exists(folder + name, failure)) return folder + name;
    }
  return "";
}

void find_allocators(Facts& facts) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"libjemalloc.so.2"},
                                                {"libtcmalloc_minimal.so.4", "libtcmalloc_minimal.so"},
                                                {"libmimalloc.so.2.0", "libmimalloc.so.2", "libmimalloc.so"}})
    if (const std::string path = first_existing(names); !path.empty()) facts.allocators.push_back(path);
}

/// Installed ones, or ones that localedef makes from its sources.
void find_locales(Facts& facts) {
  const std::string installed = probe({"locale", "-a"}).output;
  for (const char* name : {"de_DE", "tr_TR"}) {
    if (installed.find(std::string(name) + ".utf8") != std::string::npos) {
      facts.locales.push_back(std::string(name) + ".UTF-8");
      continue;
    }
    std::error_code failure;
    if (!fs::exists("/usr/share/i18n/locales/" + std::string(name), failure)) continue;
    const std::string folder = facts.folder + "/locales";
    fs::create_directories(folder, failure);
    probe({"localedef", "--no-archive", "-i", name, "-f", "UTF-8", folder + "/" + name + ".UTF-8"});
    if (!fs::exists(folder + "/" + name + ".UTF-8/LC_NUMERIC", failure)) continue;
    facts.locales.push_back(std::string(name) + ".UTF-8");
    facts.locale_folder = folder;
  }
}

}  // namespace

std::string find_program(const std::string& word) {
  std::error_code failure;
  if (word.find('/') != std::string::npos) return fs::exists(word, failure) ? word : "";
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string candidate = (folder.empty() ? "." : folder) + "/" + word;
    if (fs::exists(candidate, failure) && !fs::is_directory(candidate, failure)) return candidate;
  }
  return "";
}

Facts collect_facts(const std::vector<std::string>& words, const std::string& folder) {
  Facts facts;
  facts.folder = folder;
  facts.program = words.empty() ? "" : find_program(words.front());
#ifdef __x86_64__
  facts.is_x86_64 = true;
#endif
  constexpr std::size_t size_max = std::size_t{32} << 20;
  const std::string file = beginning_of(facts.program, size_max);
  const auto names = [&](const char* text) { return file.find(text) != std::string::npos; };
  const bool is_script = file.compare(0, 2, "#!") == 0;
  const std::string head = file.substr(0, file.find('\n'));
  facts.has_interpreter =
      names("PYTHONHASHSEED") || names("PERL_HASH_SEED") || names("libpython") ||
      (is_script && (head.find("python") != std::string::npos || head.find("perl") != std::string::npos));
  facts.has_math_library = facts.has_interpreter || names("openblas") || names("libmkl");
  find_allocators(facts);
  find_locales(facts);
  const verifier::ChildResult space = probe({"unshare", "-rT", "--fork", "--monotonic", "86400", "true"});
  if (!succeeded(space))
    facts.no_time_namespace = space.end.how == verifier::ChildEnd::How::not_started
                                  ? "unshare is not installed: apt-get install util-linux"
                                  : "this system does not permit a time namespace";
  if (facts.is_x86_64) facts.emulator = find_program("qemu-x86_64");
  return facts;
}

}  // namespace ticktrue::shake
