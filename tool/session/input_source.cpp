// Reads JSON Lines inputs line by line, and groups them into ticks.
// SPDX-License-Identifier: MIT
#include "tool/session/input_source.h"

#include <fcntl.h>
#ifndef _WIN32
#include <poll.h>
#endif
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "base/limits.h"
#include "engine/scene/scene_json.h"
#include "replay/file/file_calls.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::tool {
namespace {

constexpr std::size_t block_size = 1u << 16;

#ifdef _WIN32
/// Windows offers no such wait for a pipe: the read itself blocks, and `stop` is called at the next line.
bool wait_for_data(int, const std::function<bool()>& stop) {
  return !stop || !stop();
}
#else
/// Waits until a read does not block. False if `stop` returned true. `stop` is called several times a second, because a
/// signal just before the wait would not end the wait.
bool wait_for_data(int descriptor, const std::function<bool()>& stop) {
  constexpr int interval_ms = 100;
  struct pollfd wait {};
  wait.fd = descriptor;
  wait.events = POLLIN;
  while (true) {
    if (stop && stop()) return false;
    if (poll(&wait, 1, interval_ms) > 0) return true;
  }
}
#endif

bool is_blank(std::string_view line) {
  return line.find_first_not_of(" \t") == std::string_view::npos;
}

}  // namespace

Result<LineReader> LineReader::open(const std::string& path) {
  LineReader reader;
  if (path == "-") {
    reader.name_ = "standard input";
    reader.descriptor_ = STDIN_FILENO;
    return reader;
  }
  reader.name_ = path;
  reader.descriptor_ = replay::open_file(path, O_RDONLY);
  if (reader.descriptor_ < 0)
    return Error{ErrorCode::io, path + ": cannot open: " + verifier::system_message(errno), ""};
  reader.owned_ = true;
  struct stat status {};
  if (fstat(reader.descriptor_, &status) == 0) {
    if (S_ISDIR(status.st_mode))
      return Error{ErrorCode::io, path + ": cannot read: found a directory, expected a file of JSON Lines", ""};
    reader.is_file_ = S_ISREG(status.st_mode);
    if (reader.is_file_) reader.file_size_ = static_cast<std::uint64_t>(status.st_size);
  }
  return reader;
}

LineReader::LineReader(LineReader&& other) noexcept
    : name_(std::move(other.name_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      owned_(std::exchange(other.owned_, false)),
      is_file_(other.is_file_),
      at_end_(other.at_end_),
      file_size_(other.file_size_),
      line_number_(other.line_number_),
      offset_(other.offset_),
      buffer_(std::move(other.buffer_)),
      start_(other.start_) {}

LineReader::~LineReader() {
  if (owned_) ::close(descriptor_);
}

Result<std::optional<std::string_view>> LineReader::next(const std::function<bool()>& stop) {
  std::size_t searched = start_;
  while (true) {
    const std::size_t line_end = buffer_.find('\n', searched);
    const bool is_last = line_end == std::string::npos && at_end_;
    const std::size_t size = (line_end == std::string::npos ? buffer_.size() : line_end) - start_;
    if (size > limits::input_line_size_max) {
      ++line_number_;
      return Error{ErrorCode::limit,
                   place() + ": line: found more than " + std::to_string(limits::input_line_size_max) +
                       " bytes, expected one JSON object of at most that",
                   ""};
    }
    if (line_end != std::string::npos || (is_last && size > 0)) {
      std::string_view line = std::string_view(buffer_).substr(start_, size);
      start_ = line_end == std::string::npos ? buffer_.size() : line_end + 1;
      ++line_number_;
      if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
      return std::optional<std::string_view>(line);
    }
    if (at_end_) return std::optional<std::string_view>();

    buffer_.erase(0, start_);
    start_ = 0;
    searched = buffer_.size();
    buffer_.resize(searched + block_size);
    if (!is_file_ && !wait_for_data(descriptor_, stop)) {
      buffer_.resize(searched);
      return Error{ErrorCode::io, name_ + ": cannot read: interrupted", ""};
    }
    const auto count = ::read(descriptor_, buffer_.data() + searched, block_size);
    const int error_number = errno;
    buffer_.resize(searched + (count > 0 ? static_cast<std::size_t>(count) : 0));
    if (count < 0) {
      if (error_number == EINTR) continue;
      return Error{ErrorCode::io, name_ + ": cannot read: " + verifier::system_message(error_number), ""};
    }
    if (count == 0) at_end_ = true;
    offset_ += static_cast<std::uint64_t>(count);
  }
}

Result<std::unique_ptr<JsonLinesInputs>> JsonLinesInputs::open(const engine::Scene& scene, const std::string& path,
                                                               Options options) {
  Result<LineReader> lines = LineReader::open(path);
  if (!lines) return lines.error();
  return std::unique_ptr<JsonLinesInputs>(new JsonLinesInputs(scene, std::move(*lines), std::move(options)));
}

Status JsonLinesInputs::read_pending() {
  while (!pending_ && !at_end_) {
    const auto line = lines_.next(options_.stop);
    if (!line) return line.error();
    if (!*line) {
      at_end_ = true;
      return {};
    }
    if (is_blank(**line)) continue;
    const std::string place = lines_.place();
    if (end_tick_)
      return Error{ErrorCode::invalid_input,
                   place + ": found another input after `end`, expected none: the session ends before tick " +
                       std::to_string(*end_tick_),
                   ""};
    const Result<engine::Input> input = engine::parse_input(scene_, **line, place);
    if (!input) return input.error();
    if (input->tick < last_tick_)
      return Error{ErrorCode::invalid_input,
                   place + ": tick: found " + std::to_string(input->tick) + ", expected at least " +
                       std::to_string(last_tick_) + " (ticks ascend)",
                   "sort the lines by tick; within a tick their order counts"};
    const bool is_end = input->kind == engine::InputKind::end;
    if (is_end && last_tick_has_inputs_ && input->tick == last_tick_)
      return Error{ErrorCode::invalid_input,
                   place + ": end: found inputs of the same tick " + std::to_string(input->tick) +
                       ", expected none: `end` ends the session before its tick",
                   "give `end` the tick " + std::to_string(input->tick + 1)};
    last_tick_ = input->tick;
    last_tick_has_inputs_ = true;
    if (is_end)
      end_tick_ = input->tick;
    else
      pending_ = Line{*input, lines_.line_number()};
    // A live session ends at its `end`. In a file, a line after `end` is reported as an error.
    if (is_end && !lines_.is_file()) at_end_ = true;
  }
  return {};
}

Result<std::optional<TickInput>> JsonLinesInputs::next(std::uint64_t tick) {
  Result<std::optional<TickInput>> input = collect(tick);
  gave_error_ = !input;
  return input;
}

Result<std::optional<TickInput>> JsonLinesInputs::collect(std::uint64_t tick) {
  tick_lines_.clear();
  bytes_.clear();
  while (true) {
    if (const Status status = read_pending(); !status) return status.error();
    if (!pending_ || pending_->input.tick > tick) break;
    if (tick_lines_.size() >= limits::inputs_per_tick_max)
      return Error{ErrorCode::limit,
                   lines_.place() + ": found more than " + std::to_string(limits::inputs_per_tick_max) +
                       " inputs in tick " + std::to_string(tick) + ", expected at most that",
                   ""};
    tick_lines_.push_back(*pending_);
    pending_.reset();
  }
  if (!pending_ && end_tick_ && tick >= *end_tick_) return std::optional<TickInput>();
  if (!pending_ && !end_tick_ && options_.needs_end && tick_lines_.empty() && tick >= last_tick_)
    return Error{ErrorCode::invalid_input, lines_.name() + ": found no `end` input, expected one as the last line",
                 "append {\"tick\":" + std::to_string(tick) + ",\"kind\":\"end\"}, or give --ticks N"};

  std::stable_sort(tick_lines_.begin(), tick_lines_.end(),
                   [](const Line& a, const Line& b) { return a.input.player < b.input.player; });
  std::vector<engine::Input> inputs;
  inputs.reserve(tick_lines_.size());
  for (Line& line : tick_lines_) {
    const bool same_player = !inputs.empty() && inputs.back().player == line.input.player;
    line.input.sequence = same_player ? inputs.back().sequence + 1 : 0;
    inputs.push_back(line.input);
  }
  engine::encode_inputs(inputs, bytes_);
  count_ += inputs.size();
  return std::optional<TickInput>(TickInput{scene_.settings.dt, bytes_});
}

std::string JsonLinesInputs::place_of_refused(const Simulation& simulation) const {
  // Offers the simulation more and more inputs of the tick. An input may be valid only after an earlier one (a spawn).
  std::vector<engine::Input> inputs;
  for (const Line& line : tick_lines_) {
    inputs.push_back(line.input);
    Bytes bytes;
    engine::encode_inputs(inputs, bytes);
    if (!simulation.accept(TickInput{scene_.settings.dt, bytes}))
      return lines_.name() + ":" + std::to_string(line.number);
  }
  return lines_.name();
}

Result<InputSummary> check_inputs(const engine::Scene& scene, const std::string& path,
                                  const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  auto source = JsonLinesInputs::open(scene, path, {});
  if (!source) return source.error();
  JsonLinesInputs& inputs = **source;
  InputSummary summary;
  std::uint64_t tick_input_count = 0;
  while (true) {
    if (const Status status = inputs.read_pending(); !status) return status.error();
    if (!inputs.pending_) break;
    const std::uint64_t tick = inputs.pending_->input.tick;
    tick_input_count = summary.count > 0 && tick == summary.last_tick ? tick_input_count + 1 : 1;
    if (tick_input_count > limits::inputs_per_tick_max)
      return Error{ErrorCode::limit,
                   inputs.lines_.place() + ": found more than " + std::to_string(limits::inputs_per_tick_max) +
                       " inputs in tick " + std::to_string(tick) + ", expected at most that",
                   ""};
    summary.last_tick = tick;
    ++summary.count;
    inputs.pending_.reset();
    if (progress) progress(inputs.lines_.offset(), inputs.lines_.file_size());
  }
  summary.end_tick = inputs.end_tick_;
  return summary;
}

}  // namespace ticktrue::tool
