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
/// Whether the path has the suffix of a header.
bool is_header(std::string_view path);
/// Whether an identifier may contain this character.
bool is_word(char c);
/// Whether `path` starts with one of the comma-separated prefixes.
bool is_under(std::string_view path, std::string_view prefixes);
/// Whether `name` is one of the comma-separated names.
bool is_one_of(std::string_view name, std::string_view names);
/// The first folder of a path; empty if none.
std::string top_of(std::string_view path);
/// The folder of a path, without the last '/'.
std::string_view folder_of(std::string_view path);

std::vector<std::string> lines_of(std::string_view text);
/// The text with comments and the contents of literals blanked, with equal lines. The names in #include are kept.
std::string code_of(std::string_view text);
/// Whether `name` occurs in the line as whole words. With `call`, an opening parenthesis must follow.
bool uses(std::string_view line, std::string_view name, bool call);

/// The files of this project that a text includes, relative to the root. <ticktrue.h> becomes include/ticktrue.h.
std::set<std::string> includes_of(std::string_view text);

/// The whole file; empty if the file cannot be read.
std::string read_text(const std::filesystem::path& path);
/// Files in and below `folder` whose names have one of the suffixes, in the order of their paths.
std::vector<SourceFile> files_below(const std::filesystem::path& root, std::string_view folder,
                                    std::initializer_list<std::string_view> suffixes);
/// Headers and sources of the project, including tests and benchmarks.
std::vector<SourceFile> source_tree();

}  // namespace ticktrue::source_tree
