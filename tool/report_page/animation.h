// The animation of a trace for the report page: poses, inputs, and how each tick compares with the recording.
// SPDX-License-Identifier: MIT
//
// An animation comes from two runs. The first run goes from the start to the end of the trace, as in verify. The second
// run begins at the first tick that differs. It loads every state that the trace stores after that tick, and its frames
// count as recorded as long as its hashes agree.
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

namespace ticktrue::tool {

/// A row of a table whose bodies are requested.
struct RowQuestion {
  std::string table;
  std::uint64_t row = 0;
  std::optional<std::uint64_t> id;
  std::string name;
};

struct AnimationOptions {
  const SimulationInfo* simulation = nullptr;  // null: nothing can be simulated
  std::optional<std::uint64_t> focus;          // ticks done: near it every tick is a frame
  std::vector<RowQuestion> questions;          // about the state at the focus
  std::size_t pose_count_max = 2'000'000;      // with more, every second frame is dropped, then every second again
  std::size_t body_count_max = 20'000;         // with more bodies the animation has no poses
  std::size_t input_text_size_max = 400'000;   // bytes of input lines; more are counted, not listed
  std::function<void(std::uint64_t ticks_done)> progress;  // may be empty
};

struct AnimatedBody {
  std::uint32_t id = 0;
  std::uint32_t figure = 0;  // index in Animation::figures
  std::string name;
};

struct Pose {
  std::uint32_t body = 0;  // index in Animation::bodies
  double x = 0;            // centre of mass, world, m
  double y = 0;
  double angle = 0;  // rad, continuous from frame to frame
};

/// Sums over a state.
struct FrameSums {
  double kinetic = 0;      // J
  double potential = 0;    // J, of gravity, 0 at the origin of the world
  double momentum_x = 0;   // kg m/s
  double momentum_y = 0;   // kg m/s
  double penetration = 0;  // m, of the deepest contact; 0: none overlaps
  std::uint32_t contact_count = 0;
};

struct Frame {
  std::uint64_t ticks_done = 0;
  double time_s = 0;
  std::vector<Pose> poses;  // ascending by body; bodies that are not finite are missing
  FrameSums sums;
};

/// How ticks compare with the recording.
enum class TickMatch : std::uint8_t {
  same,           // bit for bit
  differs,        // the recorded state is not known
  differs_known,  // the recorded state is known, from a stored state and the hashes after it
  not_compared,   // read, not simulated
  unread,         // after a cut or damage
  unread_intact,  // after damage, intact
};

struct MatchRange {
  std::uint64_t first = 0;  // tick
  std::uint64_t last = 0;   // inclusive
  TickMatch match = TickMatch::same;
};

struct InputTick {
  std::uint64_t tick = 0;
  std::uint32_t count = 0;
};

struct Animation {
  std::string no_poses;  // one sentence: why there are no poses; empty: there are poses
  std::vector<Figure> figures;
  std::vector<AnimatedBody> bodies;  // in order of first appearance
  std::vector<Frame> frames;         // of the run from the start; ascending
  std::vector<Frame> recorded;       // where `frames` differs: the recorded frames, as far as they are known
  std::uint64_t stride = 1;          // frames are stored at multiples of it,
  std::uint64_t exact_first = 0;     // and all of these, in ticks done,
  std::uint64_t exact_last = 0;      // and the last one
  std::vector<std::uint32_t> named;  // bodies of the rows in `questions`
  std::vector<MatchRange> match_ranges;
  std::uint64_t tick_count = 0;  // of match_ranges: ticks recorded, or ticks readable if that is unknown
  std::uint64_t ticks_run = 0;
  double time_s = 0;                       // simulated
  std::string stopped;                     // why the run ended early; may be empty
  std::vector<std::uint64_t> checkpoints;  // ticks done
  std::vector<InputTick> input_ticks;
  std::uint64_t input_count = 0;
  std::vector<std::pair<std::uint64_t, std::string>>
      input_lines;                  // tick, JSON; the first lines, and every line of the focus
  std::vector<engine::Point> view;  // lower and upper corner of the visible rectangle; empty without poses
};

/// Simulates the trace from its start, as far as it is intact.
Animation make_animation(replay::TraceReader& reader, const AnimationOptions& options);

/// Marks a tick as different if match_ranges has it as the same.
void mark_differing(Animation& animation, std::uint64_t tick);

/// Drops every second frame, except near the focus. False: no frame can be dropped.
bool halve_frames(Animation& animation);

/// Whether the animation has a frame at this time.
bool includes_frame(const Animation& animation, std::uint64_t ticks_done);

}  // namespace ticktrue::tool
