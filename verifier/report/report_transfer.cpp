// The fields of a report, listed once: the same list writes and reads.
// SPDX-License-Identifier: MIT
#include "verifier/report/report_transfer.h"

#include <concepts>
#include <type_traits>
#include <utility>

namespace ticktrue::verifier {
namespace {

class Writer {
 public:
  template <typename... T>
  void operator()(T&... values) {
    (put(values), ...);
  }
  Bytes take() { return out_.take(); }

 private:
  template <typename T>
  void put(T& value);
  ByteWriter out_;
};

class Reader {
 public:
  explicit Reader(ByteView bytes) : in_(bytes) {}
  template <typename... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  bool is_done() const { return in_.ok() && in_.at_end(); }

 private:
  template <typename T>
  void get(T& value);
  ByteReader in_;
};

template <typename Io>
void fields(Io& io, LaneReport& x) {
  io(x.table, x.column, x.row, x.id, x.name, x.lane, x.lane_count, x.type, x.expected, x.got, x.place);
}
template <typename Io>
void fields(Io& io, ContentReport& x) {
  io(x.place, x.table, x.row, x.id, x.name, x.is_text, x.expected, x.got, x.first, x.expected_size, x.got_size,
     x.offset, x.character);
}
template <typename Io>
void fields(Io& io, TableDifference& x) {
  io(x.table, x.columns, x.is_content);
}
template <typename Io>
void fields(Io& io, Candidate& x) {
  io(x.table, x.row, x.id, x.name, x.place);
}
template <typename Io>
void fields(Io& io, RowCountDifference& x) {
  io(x.table, x.expected, x.got);
}
template <typename Io>
void fields(Io& io, Spread& x) {
  io(x.tick, x.row_count, x.of, x.estimated);
}
template <typename Io>
void fields(Io& io, Divergence& x) {
  io(x.tick, x.time_s, x.stage, x.stage_note, x.tables, x.rows, x.lane_count, x.from_cells, x.row_counts, x.candidates,
     x.candidate_count, x.owner_count, x.healed, x.unexplained_cells, x.spread, x.expected_root, x.got_root, x.inputs,
     x.contents, x.content_count);
}
template <typename Io>
void fields(Io& io, ComparedParts& x) {
  io(x.ticks, x.stage_hashes, x.images, x.cells, x.marks);
}
template <typename Io>
void fields(Io& io, NameDifference& x) {
  io(x.name, x.expected, x.got);
}
template <typename Io>
void fields(Io& io, MarksDifference& x) {
  io(x.tick, x.names, x.name_count);
}
template <typename Io>
void fields(Io& io, replay::Note& x) {
  io(x.topic, x.text);
}
template <typename Io>
void fields(Io& io, NonFinite& x) {
  io(x.tick, x.table, x.row, x.row_name, x.column, x.lane, x.value);
}
template <typename Io>
void fields(Io& io, replay::EndRecord& x) {
  io(x.reason, x.tick_count, x.note);
}
template <typename Io>
void fields(Io& io, replay::IntactRange& x) {
  io(x.first_tick, x.last_tick, x.has_checkpoint);
}
template <typename Io>
void fields(Io& io, replay::TraceTail& x) {
  io(x.condition, x.ticks_intact, x.offset, x.message, x.end, x.has_pending_inputs, x.pending_dt, x.pending_inputs,
     x.pending_notes, x.intact_after);
}
template <typename Io>
void fields(Io& io, TraceEnd& x) {
  io(x.tail, x.pending_inputs, x.salvaged_from);
}
template <typename Io>
void fields(Io& io, OtherBuild& x) {
  io(x.binary, x.verdict, x.reason, x.ticks_compared, x.diverged_at, x.facts, x.is_expected);
}
template <typename Io, typename First, typename Second>
void fields(Io& io, std::pair<First, Second>& x) {
  io(x.first, x.second);
}
template <typename Io>
void fields(Io& io, Report& x) {
  io(x.file, x.title, x.simulation, x.mode, x.verdict, x.reason, x.hint, x.ticks_recorded, x.ticks_compared,
     x.first_tick, x.time_s, x.root_hash, x.checkpoints_compared, x.compared, x.state_changed, x.segments, x.wall_s,
     x.divergence, x.marks, x.checkpoint, x.non_finite, x.end, x.warnings, x.notes, x.recorded_build, x.here_build,
     x.against, x.again);
}

template <typename T>
constexpr bool is_optional = false;
template <typename T>
constexpr bool is_optional<std::optional<T>> = true;
template <typename T>
constexpr bool is_list = false;
template <typename T>
constexpr bool is_list<std::vector<T>> = true;
template <typename T>
concept Number = std::integral<T> || std::is_enum_v<T>;

// The known values of the enumerations in a report.
constexpr bool is_known(Verdict value) {
  return value <= Verdict::error;
}
constexpr bool is_known(ScalarType value) {
  return value >= ScalarType::u8 && value <= ScalarType::f64;
}
constexpr bool is_known(replay::EndReason value) {
  return value >= replay::EndReason::complete && value <= replay::EndReason::recovered;
}
constexpr bool is_known(replay::TraceCondition value) {
  return value <= replay::TraceCondition::damaged;
}

template <typename T>
void Writer::put(T& value) {
  if constexpr (Number<T>) {
    out_.u64(static_cast<std::uint64_t>(value));
  } else if constexpr (std::is_same_v<T, double>) {
    out_.f64(value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    out_.text(value);
  } else if constexpr (is_optional<T>) {
    out_.u8(value.has_value() ? 1 : 0);
    if (value) put(*value);
  } else if constexpr (is_list<T>) {
    out_.u64(value.size());
    for (auto& element : value) put(element);
  } else {
    fields(*this, value);
  }
}

template <typename T>
void Reader::get(T& value) {
  if constexpr (std::is_enum_v<T>) {
    const std::uint64_t number = in_.u64();
    value = static_cast<T>(number);
    if (number != static_cast<std::uint64_t>(value) || !is_known(value)) in_.fail();
  } else if constexpr (Number<T>) {
    value = static_cast<T>(in_.u64());
  } else if constexpr (std::is_same_v<T, double>) {
    value = in_.f64();
  } else if constexpr (std::is_same_v<T, std::string>) {
    value = in_.text(in_.remaining());
  } else if constexpr (is_optional<T>) {
    value.reset();
    if (in_.u8() != 0 && in_.ok()) get(value.emplace());
  } else if constexpr (is_list<T>) {
    value.clear();
    const std::uint64_t count = in_.u64();
    for (std::uint64_t i = 0; i < count && in_.ok(); ++i) get(value.emplace_back());
  } else {
    fields(*this, value);
  }
}

}  // namespace

Bytes encode_report(Report report) {
  Writer out;
  out(report);
  return out.take();
}

Result<Report> decode_report(ByteView bytes) {
  Reader in(bytes);
  Report report;
  in(report);
  if (!in.is_done()) return Error{ErrorCode::corrupt, "the report of a child process is not whole", ""};
  return report;
}

}  // namespace ticktrue::verifier
