// A trace played once for a page: where every body was, how each tick compares with the recording, what came in.
// SPDX-License-Identifier: MIT
//
// Two runs stand behind a film. One goes on from the start, as verify does, whatever it finds. From the first tick that
// differs on, the other one begins anew with every state that the trace stores, so that what was recorded is known
// again for as long as its hashes are the recorded ones.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/state/simulation.h"
#include "replay/trace_reader.h"
#include "tool/drawing/drawing.h"

namespace ticktrue::verifier {

/// A row of a table of which one wants to know the bodies.
struct RowQuestion {
  std::string table;
  std::uint64_t row = 0;
  std::optional<std::uint64_t> id;
  std::string name;
};

struct FilmOptions {
  const SimulationInfo* simulation = nullptr;  // null: nothing can be simulated
  std::optional<std::uint64_t> focus;          // ticks done: around it every tick is kept
  std::vector<RowQuestion> questions;          // about the state at the focus
  std::size_t pose_count_max = 2'000'000;      // more are thinned out: every second frame, every fourth, ...
  std::size_t body_count_max = 20'000;         // with more there are no poses at all
  std::size_t input_text_size_max = 400'000;   // bytes of input lines; more are counted, not listed
  std::function<void(std::uint64_t ticks_done)> progress;  // may be empty
};

struct FilmBody {
  std::uint32_t id = 0;
  std::uint32_t figure = 0;  // index in Film::figures
  std::string name;
};

struct FilmPose {
  std::uint32_t body = 0;  // index in Film::bodies
  double x = 0;            // centre of mass, world, m
  double y = 0;
  double angle = 0;  // rad, without jumps from frame to frame
};

/// What a state sums up to.
struct FilmSums {
  double kinetic = 0;      // J
  double potential = 0;    // J, of gravity, 0 at the origin of the world
  double momentum_x = 0;   // kg m/s
  double momentum_y = 0;   // kg m/s
  double penetration = 0;  // m, of the deepest contact; 0: none overlaps
  std::uint32_t contact_count = 0;
};

struct FilmFrame {
  std::uint64_t ticks_done = 0;
  double time_s = 0;
  std::vector<FilmPose> poses;  // ascending by body; bodies that are not finite are missing
  FilmSums sums;
};

/// How ticks compare with the recording.
enum class TickMatch : std::uint8_t {
  same,           // bit for bit
  differs,        // and what was recorded is not known
  differs_known,  // and what was recorded is known, by a stored state and the hashes behind it
  not_compared,   // read, but nothing ran
  unread,         // behind a cut or damage
  unread_intact,  // behind damage, whole
};

struct StripPart {
  std::uint64_t first = 0;  // tick
  std::uint64_t last = 0;   // inclusive
  TickMatch match = TickMatch::same;
};

struct InputTick {
  std::uint64_t tick = 0;
  std::uint32_t count = 0;
};

struct Film {
  std::string no_poses;  // one sentence: why there are none; empty: there are
  std::vector<Figure> figures;
  std::vector<FilmBody> bodies;      // in the order in which they were first seen
  std::vector<FilmFrame> frames;     // of the run from the start; ascending
  std::vector<FilmFrame> recorded;   // where that differs: what was recorded, as far as it is known
  std::uint64_t stride = 1;          // frames are kept at multiples of it,
  std::uint64_t exact_first = 0;     // and all of these, in ticks done,
  std::uint64_t exact_last = 0;      // and the last one
  std::vector<std::uint32_t> named;  // bodies that the questions name
  std::vector<StripPart> strip;
  std::uint64_t tick_count = 0;  // of the strip: recorded, or readable where that is not known
  std::uint64_t ticks_run = 0;
  double time_s = 0;                       // simulated
  std::string stopped;                     // why the run ended early; may be empty
  std::vector<std::uint64_t> checkpoints;  // ticks done
  std::vector<InputTick> input_ticks;
  std::uint64_t input_count = 0;
  std::vector<std::pair<std::uint64_t, std::string>> input_lines;  // tick, JSON; the first of them, all of the focus
  std::vector<engine::Point> view;  // lower, upper corner of what to show; empty without poses
};

/// Plays the trace from its start as far as it is intact.
Film make_film(replay::TraceReader& reader, const FilmOptions& options);

/// The tick differs, where the strip says that it is the same.
void mark_differing(Film& film, std::uint64_t tick);

/// Halves the frames, but for those around the focus. False: nothing is left to leave out.
bool thin_out(Film& film);

/// Whether the frame is kept.
bool keeps_frame(const Film& film, std::uint64_t ticks_done);

}  // namespace ticktrue::verifier
