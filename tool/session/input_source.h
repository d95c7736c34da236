// Inputs of the engine as JSON Lines, from a file or live from a pipe, tick by tick in bounded memory.
// SPDX-License-Identifier: MIT
//
// One JSON object per line (engine/scene/scene_json.h), ticks ascending; blank lines are skipped. The inputs of a tick
// are complete after a line of a later tick, an `end` or the end of the file. No input may follow an `end`, even within
// its tick. Within a tick, inputs apply player by player, and the inputs of a player apply in the order of the lines.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/simulation.h"
#include "engine/scene/input.h"
#include "engine/scene/scene.h"
#include "replay/recorder.h"

namespace ticktrue::tool {

/// Reads lines of bounded length from a file or a pipe, as they arrive.
class LineReader {
 public:
  /// `path` "-": standard input. Errors: io.
  static Result<LineReader> open(const std::string& path);
  LineReader(LineReader&& other) noexcept;
  LineReader& operator=(LineReader&&) = delete;
  ~LineReader();

  /// The next line without its line break, valid until the next call; absent at the end. `stop` is called while the
  /// reader waits for a pipe. Errors: io, limit (a line too long).
  Result<std::optional<std::string_view>> next(const std::function<bool()>& stop);

  const std::string& name() const { return name_; }           // for messages: the path, or "standard input"
  std::uint64_t line_number() const { return line_number_; }  // of the last returned line, from 1
  std::uint64_t offset() const { return offset_; }            // bytes read so far
  bool is_file() const { return is_file_; }                   // a regular file, which can be read again
  std::uint64_t file_size() const { return file_size_; }      // bytes; 0 if unknown
  std::string place() const { return name_ + ":" + std::to_string(line_number_); }

 private:
  LineReader() = default;

  std::string name_;
  int descriptor_ = -1;
  bool owned_ = false;
  bool is_file_ = false;
  bool at_end_ = false;
  std::uint64_t file_size_ = 0;
  std::uint64_t line_number_ = 0;
  std::uint64_t offset_ = 0;
  std::string buffer_;
  std::size_t start_ = 0;  // the first byte in the buffer that is not yet returned
};

/// A summary of a file of inputs.
struct InputSummary {
  std::uint64_t count = 0;                // inputs other than `end`
  std::uint64_t last_tick = 0;            // of the last input; 0 without inputs
  std::optional<std::uint64_t> end_tick;  // of the `end` input
};

class JsonLinesInputs : public replay::InputSource {
 public:
  struct Options {
    bool needs_end = false;      // an input file without `end` is an error
    std::function<bool()> stop;  // called while waiting for live inputs; true: io error; may be empty
  };
  /// The scene must outlive the source. `path` "-": standard input. Errors: io.
  static Result<std::unique_ptr<JsonLinesInputs>> open(const engine::Scene& scene, const std::string& path,
                                                       Options options);

  Result<std::optional<TickInput>> next(std::uint64_t tick) override;
  bool repeatable() const override { return lines_.is_file(); }

  /// The place "file:line" of the first input in the last returned tick that `simulation` refuses. Requires:
  /// `simulation` refused the tick.
  std::string place_of_refused(const Simulation& simulation) const;

  /// Whether next() failed. The message of its error then already contains the place.
  bool gave_error() const { return gave_error_; }
  std::uint64_t count() const { return count_; }  // inputs returned so far

 private:
  struct Line {
    engine::Input input;
    std::uint64_t number = 0;
  };
  friend Result<InputSummary> check_inputs(const engine::Scene& scene, const std::string& path,
                                           const std::function<void(std::uint64_t, std::uint64_t)>& progress);

  JsonLinesInputs(const engine::Scene& scene, LineReader lines, Options options)
      : scene_(scene), options_(std::move(options)), lines_(std::move(lines)) {}
  /// Reads the next input into pending_, and checks the input and its order. pending_ is empty at the end.
  Status read_pending();
  Result<std::optional<TickInput>> collect(std::uint64_t tick);

  const engine::Scene& scene_;
  Options options_;
  LineReader lines_;
  std::optional<Line> pending_;  // read, but not yet returned
  bool at_end_ = false;          // no line follows pending_
  std::optional<std::uint64_t> end_tick_;
  std::uint64_t last_tick_ = 0;
  bool last_tick_has_inputs_ = false;
  std::vector<Line> tick_lines_;  // lines of the last returned tick, in the order in which they apply
  Bytes bytes_;
  std::uint64_t count_ = 0;
  bool gave_error_ = false;
};

/// Reads a whole file and checks each line before the session begins. Errors that only a running simulation can detect
/// (an unknown id) are not checked. `progress` (bytes done, bytes in total) may be empty. Errors: io, invalid_input,
/// limit.
Result<InputSummary> check_inputs(const engine::Scene& scene, const std::string& path,
                                  const std::function<void(std::uint64_t, std::uint64_t)>& progress);

}  // namespace ticktrue::tool
