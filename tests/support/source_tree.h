// The sources of this project as text, for tests of the sources themselves.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace ticktrue::source_tree {

struct SourceFile {
  std::string path;  // from the root, with '/'
  std::string text;
};

bool starts_with(std::string_view text, std::string_view prefix);
bool ends_with(std::string_view text, std::string_view suffix);
bool contains(std::string_view text, std::string_view part);
/// Whether the path ends as those of headers do.
bool is_header(std::string_view path);
/// Whether an identifier may have this character.
bool is_word(char c);
/// The first folder of a path, or nothing.
std::string top_of(std::string_view path);

std::vector<std::string> lines_of(std::string_view text);
/// The same text with comments and the insides of literals blanked, line for line. The names in #include stay.
std::string code_of(std::string_view text);
/// Whether `name` stands in the line as whole words; with `call`, only where an opening parenthesis follows.
bool uses(std::string_view line, std::string_view name, bool call);

/// The files of this project that a text includes, from the root: "base/hash.h", and <ticktrue.h> as
/// include/ticktrue.h.
std::set<std::string> includes_of(std::string_view text);

/// The whole file; an empty text where it cannot be read.
std::string read_text(const std::filesystem::path& path);
/// Files in `folder` and below whose names end so, in the order of their paths.
std::vector<SourceFile> files_below(const std::filesystem::path& root, std::string_view folder,
                                    std::initializer_list<std::string_view> suffixes);
/// Headers and sources of the project, tests and benchmarks included.
std::vector<SourceFile> source_tree();

}  // namespace ticktrue::source_tree
