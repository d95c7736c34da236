// The limits of all outside data. Each limit is checked before memory is allocated or work begins.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace ticktrue::limits {

// Scenes and inputs.
inline constexpr std::size_t scene_file_size_max = 256u << 20;  // a million bodies of 256 B of JSON each
inline constexpr std::size_t body_count_max = 200'000;          // twice the largest measured scene
inline constexpr std::size_t prototype_count_max = 4'096;       // kinds of spawned bodies, not bodies
inline constexpr std::size_t shape_count_per_body_max = 1'024;  // a terrain body has hundreds of pieces
inline constexpr std::size_t polygon_vertex_count_min = 3;
inline constexpr std::size_t polygon_vertex_count_max = 16;      // hot records hold a hull without indirection
inline constexpr std::size_t chain_vertex_count_max = 16'384;    // the outline of a level
inline constexpr std::size_t child_count_per_body_max = 65'536;  // its shapes; each edge of a chain counts
inline constexpr std::size_t joint_count_max = 200'000;          // one per body
inline constexpr std::size_t force_count_max = 4'096;            // each is evaluated at every stage of every substep
// Pairs of shapes near each other in a tick, each up to 900 bytes: three to six per body in piles, and 362 bodies in
// one place.
constexpr std::size_t pair_count_max(std::size_t body_count) {
  return 65'536 + 32 * body_count;
}
inline constexpr int iteration_count_max = 1'000;
inline constexpr int ticks_per_frame_max = 1'000;
inline constexpr std::size_t name_size_max = 256;     // bytes of UTF-8
inline constexpr std::size_t player_count_max = 256;  // lockstep sessions have 2..16
inline constexpr std::size_t inputs_per_tick_max =
    16'384;  // a burst, not a file; at 56 B each they fit record_size_max
inline constexpr std::size_t input_line_size_max = 64u << 10;  // one JSON object
inline constexpr int substep_count_max = 256;                  // bounds the work of one tick
inline constexpr double dt_max_s = 1.0;                        // longer ticks simulate nothing useful
inline constexpr double dt_min_s = 1e-9;
inline constexpr double coordinate_max_m = 1e7;  // f32 resolves 1 m there, f64 2 nm
inline constexpr double size_min_m = 1e-6;       // for smaller shapes, areas underflow in f32
inline constexpr double size_max_m = 1e6;
inline constexpr double speed_max = 1e9;  // m/s or rad/s of a scene or an input
inline constexpr double mass_max_kg = 1e15;
inline constexpr double mass_min_kg = 1e-15;
inline constexpr std::uint64_t tick_count_max = 1ull << 40;  // 580 years at 60 Hz

// Traces.
inline constexpr std::size_t record_size_max = 1u << 20;       // the buffer of a reader for a record
inline constexpr std::size_t chunk_size_max = 16u << 20;       // the buffer of a reader for a chunk
inline constexpr std::size_t setup_size_max = 256u << 20;      // a scene of body_count_max bodies
inline constexpr std::size_t state_image_size_max = 1u << 30;  // body_count_max bodies with their contacts, f64
// A compressed image may be thousands of times larger than its bytes in the file. For a trace of `file_size` bytes, a
// reader holds at most image_held_max(file_size) bytes of one image. It unpacks at most images_unpacked_max(file_size)
// bytes in one reading. A writer that would exceed either limit stores the part uncompressed.
constexpr std::uint64_t image_held_max(std::uint64_t file_size) {
  return (8u << 20) + 16 * file_size;
}
constexpr std::uint64_t images_unpacked_max(std::uint64_t file_size) {
  return (1u << 30) + 256 * file_size;
}
// For image_held_max, a composed state, or the parts of one checkpoint (state, shown image, save), count as one image.
inline constexpr std::size_t shown_size_max = 256u << 20;           // shown image of one state
inline constexpr std::size_t save_size_max = 256u << 20;            // save of one checkpoint
inline constexpr std::size_t table_count_max = 64;                  // of a trace of format versions 1 and 2
inline constexpr std::size_t registered_table_count_max = 4'096;    // of a program, and of a trace of version 3
inline constexpr std::size_t registered_column_count_max = 65'536;  // of all these tables
inline constexpr std::size_t column_count_max = 256;                // per table
inline constexpr std::size_t row_size_max = 4'096;                  // bytes
inline constexpr std::size_t row_count_max = 1u << 26;              // rows of one table
inline constexpr std::size_t stage_count_max = 256;

}  // namespace ticktrue::limits
