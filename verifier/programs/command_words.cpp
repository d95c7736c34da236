// Splits commands with quotes and backslashes as in POSIX.1-2017, Shell Command Language, 2.2 Quoting.
// SPDX-License-Identifier: MIT
#include "verifier/programs/command_words.h"

#include "verifier/report/report.h"

namespace ticktrue::verifier {
namespace {

constexpr std::string_view shell_characters = "|&;<>()$`";

class Splitter {
 public:
  Splitter(std::string_view text, std::string_view option) : text_(text), option_(option) {}

  Result<std::vector<std::string>> run() {
    while (at_ < text_.size())
      if (const Status status = take(text_[at_++]); !status) return status.error();
    end_word();
    if (words_.empty())
      return refuse("found no word, expected a program and its arguments",
                    "as in " + option_ + " './mygame --verify {}'");
    return std::move(words_);
  }

 private:
  Error refuse(const std::string& what, const std::string& hint) const {
    return Error{ErrorCode::usage, option_ + ": " + what, hint};
  }

  void end_word() {
    if (has_word_) words_.push_back(std::move(word_));
    word_.clear();
    has_word_ = false;
  }

  Status take(char c) {
    if (c == ' ' || c == '\t' || c == '\n') {
      end_word();
      return {};
    }
    if (shell_characters.find(c) != std::string_view::npos)
      return refuse(std::string("found ") + c + " outside of quotes, expected words: no shell runs the command",
                    "quote it, or name a shell: " + option_ + " \"sh -c '...'\"");
    has_word_ = true;
    if (c == '\'' || c == '"') return take_quoted(c);
    if (c == '\\') {
      if (at_ == text_.size()) return refuse("found \\ at its end, expected a character behind it", "");
      c = text_[at_++];
    }
    word_ += c;
    return {};
  }

  Status take_quoted(char quote) {
    for (; at_ < text_.size() && text_[at_] != quote; ++at_) {
      const bool is_escape = quote == '"' && text_[at_] == '\\' && at_ + 1 < text_.size() &&
                             std::string_view("\"\\$`").find(text_[at_ + 1]) != std::string_view::npos;
      word_ += text_[is_escape ? ++at_ : at_];
    }
    if (at_ == text_.size()) return refuse(std::string("found no second ") + quote + ", expected one", "");
    ++at_;
    return {};
  }

  std::string_view text_;
  std::string option_;
  std::size_t at_ = 0;
  std::vector<std::string> words_;
  std::string word_;
  bool has_word_ = false;
};

}  // namespace

Result<std::vector<std::string>> split_command(std::string_view text, std::string_view option) {
  return Splitter(text, option).run();
}

std::vector<bool> replace_marks(std::vector<std::string>& words, std::span<const CommandMark> marks) {
  std::vector<bool> found(marks.size());
  for (std::string& word : words)
    for (std::size_t at = word.find('{'); at != std::string::npos; at = word.find('{', at)) {
      std::size_t next = at + 1;
      for (std::size_t i = 0; i < marks.size(); ++i) {
        if (word.compare(at, marks[i].mark.size(), marks[i].mark) != 0) continue;
        word.replace(at, marks[i].mark.size(), marks[i].text);
        next = at + marks[i].text.size();
        found[i] = true;
        break;
      }
      at = next;
    }
  return found;
}

std::string command_line_of(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    const bool is_mark = word == "{}" || word == "{trace}" || word == "{seed}";
    line += (line.empty() ? "" : " ") + (is_mark ? word : shell_word(word));
  }
  return line;
}

std::vector<std::string> with_trace(std::vector<std::string> words, const std::string& trace) {
  const CommandMark marks[] = {{"{}", trace}, {"{trace}", trace}};
  const std::vector<bool> found = replace_marks(words, marks);
  if (!found[0] && !found[1]) words.insert(words.end(), {"--verify", trace});
  return words;
}

}  // namespace ticktrue::verifier
