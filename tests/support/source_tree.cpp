// Reads sources and finds code in their text.
// SPDX-License-Identifier: MIT
#include "tests/support/source_tree.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <utility>

namespace ticktrue::source_tree {
namespace {

namespace fs = std::filesystem;

constexpr std::array source_folders{"include", "base", "engine", "replay", "verifier",
                                    "tool",    "capi", "shim",   "tests",  "bench"};

}  // namespace

bool starts_with(std::string_view text, std::string_view prefix) {
  return text.substr(0, prefix.size()) == prefix;
}
bool ends_with(std::string_view text, std::string_view suffix) {
  return text.size() >= suffix.size() && text.substr(text.size() - suffix.size()) == suffix;
}
bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}
bool is_header(std::string_view path) {
  return ends_with(path, ".h") || ends_with(path, ".hpp");
}

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

bool is_under(std::string_view path, std::string_view prefixes) {
  while (!prefixes.empty()) {
    const std::size_t comma = std::min(prefixes.find(','), prefixes.size());
    if (starts_with(path, prefixes.substr(0, comma))) return true;
    prefixes.remove_prefix(std::min(comma + 1, prefixes.size()));
  }
  return false;
}

bool is_one_of(std::string_view name, std::string_view names) {
  while (!names.empty()) {
    const std::size_t comma = std::min(names.find(','), names.size());
    if (names.substr(0, comma) == name) return true;
    names.remove_prefix(std::min(comma + 1, names.size()));
  }
  return false;
}

std::string_view folder_of(std::string_view path) {
  return path.substr(0, std::min(path.rfind('/'), path.size()));
}

std::string top_of(std::string_view path) {
  const std::size_t slash = path.find('/');
  return std::string(slash == std::string_view::npos ? std::string_view{} : path.substr(0, slash));
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < text.size()) {
    std::size_t end = text.find('\n', begin);
    if (end == std::string_view::npos) end = text.size();
    lines.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string code_of(std::string_view text) {
  std::string code(text);
  const auto blank = [&code](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && i < code.size(); ++i)
      if (code[i] != '\n') code[i] = ' ';
  };
  bool in_include = false;
  std::size_t i = 0;
  while (i < text.size()) {
    if (text[i] == '\n') {
      in_include = false;
      ++i;
    } else if (starts_with(text.substr(i), "#include")) {
      in_include = true;
      i += 8;
    } else if (starts_with(text.substr(i), "//")) {
      std::size_t end = text.find('\n', i);
      if (end == std::string_view::npos) end = text.size();
      blank(i, end);
      i = end;
    } else if (starts_with(text.substr(i), "/*")) {
      const std::size_t close = text.find("*/", i + 2);
      const std::size_t end = close == std::string_view::npos ? text.size() : close + 2;
      blank(i, end);
      i = end;
    } else if (text[i] == '"' && i > 0 && text[i - 1] == 'R') {
      const std::size_t open = text.find('(', i);
      if (open == std::string_view::npos) break;
      const std::string closing = ")" + std::string(text.substr(i + 1, open - i - 1)) + "\"";
      const std::size_t close = text.find(closing, open);
      const std::size_t end = close == std::string_view::npos ? text.size() : close + closing.size();
      blank(i, end);
      i = end;
    } else if ((text[i] == '"' && !in_include) || (text[i] == '\'' && (i == 0 || !is_word(text[i - 1])))) {
      std::size_t end = i + 1;  // a quote after a word character is a digit separator
      while (end < text.size() && text[end] != text[i] && text[end] != '\n') end += text[end] == '\\' ? 2u : 1u;
      blank(i + 1, end);
      i = end + 1;
    } else {
      ++i;
    }
  }
  return code;
}

bool uses(std::string_view line, std::string_view name, bool call) {
  for (std::size_t at = line.find(name); at != std::string_view::npos; at = line.find(name, at + 1)) {
    if (at > 0 && is_word(line[at - 1])) continue;
    std::size_t end = at + name.size();
    if (end < line.size() && is_word(line[end]) && is_word(name.back())) continue;
    if (!call) return true;
    while (end < line.size() && line[end] == ' ') ++end;
    if (end < line.size() && line[end] == '(') return true;
  }
  return false;
}

std::set<std::string> includes_of(std::string_view text) {
  std::set<std::string> includes;
  for (const std::string& line : lines_of(code_of(text))) {
    const std::size_t name = std::string_view("#include <").size();
    if (starts_with(line, "#include \"")) includes.insert(line.substr(name, line.find('"', name) - name));
    if (starts_with(line, "#include <ticktrue")) includes.insert("include/" + line.substr(name, line.find('>') - name));
  }
  return includes;
}

std::string read_text(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<SourceFile> files_below(const fs::path& root, std::string_view folder,
                                    std::initializer_list<std::string_view> suffixes) {
  std::vector<SourceFile> files;
  if (!fs::exists(root / folder)) return files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string path = entry.path().lexically_relative(root).generic_string();
    if (std::any_of(suffixes.begin(), suffixes.end(), [&](std::string_view suffix) { return ends_with(path, suffix); }))
      files.push_back({path, read_text(entry.path())});
  }
  std::sort(files.begin(), files.end(), [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
  return files;
}

std::vector<SourceFile> source_tree() {
  std::vector<SourceFile> files;
  for (const char* folder : source_folders)
    for (SourceFile& file : files_below(TICKTRUE_SOURCE_DIR, folder, {".h", ".hpp", ".cpp"}))
      files.push_back(std::move(file));
  return files;
}

}  // namespace ticktrue::source_tree
