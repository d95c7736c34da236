// Quotes and backslashes as in POSIX.1-2017, Shell Command Language, 2.2 Quoting.
// SPDX-License-Identifier: MIT
#include "verifier/programs/command_words.h"

namespace ticktrue::verifier {
namespace {

constexpr std::string_view shell_characters = "|&;<>()$`";

Error refuse(const std::string& what, const std::string& hint) {
  return Error{ErrorCode::usage, "--command: " + what, hint};
}

class Splitter {
 public:
  explicit Splitter(std::string_view text) : text_(text) {}

  Result<std::vector<std::string>> run() {
    while (at_ < text_.size())
      if (const Status status = take(text_[at_++]); !status) return status.error();
    end_word();
    if (words_.empty())
      return refuse("found no word, expected a program and its arguments", "as in --command './mygame --verify {}'");
    return std::move(words_);
  }

 private:
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
                    "quote it, or name a shell: --command \"sh -c '...'\"");
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
  std::size_t at_ = 0;
  std::vector<std::string> words_;
  std::string word_;
  bool has_word_ = false;
};

}  // namespace

Result<std::vector<std::string>> split_command(std::string_view text) {
  return Splitter(text).run();
}

std::vector<std::string> with_trace(std::vector<std::string> words, const std::string& trace) {
  bool has_mark = false;
  for (std::string& word : words)
    for (std::size_t at = word.find('{'); at != std::string::npos; at = word.find('{', at)) {
      std::size_t size = 0;
      for (const std::string_view mark : {"{}", "{trace}"})
        if (word.compare(at, mark.size(), mark) == 0) size = mark.size();
      if (size > 0) word.replace(at, size, trace);
      has_mark = has_mark || size > 0;
      at += size > 0 ? trace.size() : 1;
    }
  if (!has_mark) words.insert(words.end(), {"--verify", trace});
  return words;
}

}  // namespace ticktrue::verifier
