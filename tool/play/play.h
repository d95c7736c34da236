// What `ticktrue play` is asked to do. The command is parsed here; play/ above carries it out.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ticktrue::cli {

struct PlayOptions {
  std::string what;    // a scene, or a trace (.ttr)
  std::string output;  // of a scene; empty: session-1.ttr and on
  bool force = false;
  std::string against;            // of a trace: another one
  std::uint64_t from = 0;         // of a trace: where it begins
  bool headless = false;          // no window
  double hz = 60;                 // frames per second, headless
  std::uint64_t frame_count = 0;  // ends after so many; 0: when asked to
  std::string script;
  std::string layers;  // keys of the layers that are on at first
  int width = 1280;    // px
  int height = 800;
  std::string screenshot;  // .png, of the last picture
  std::string dump;        // .json: what was drawn last, beside the state
  bool json = false;
};

/// Returns the exit code. Defined in tool/play/command.cpp.
int run_play(const PlayOptions& options);

}  // namespace ticktrue::cli
