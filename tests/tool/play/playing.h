// Plays scripted sessions without a display, for tests of the window.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/engine.h"
#include "tool/play/play_scene.h"
#include "tool/play/session.h"
#include "tool/play/window/host.h"
#include "tool/session/session.h"

namespace ticktrue::test {

/// A directory that is removed with this object.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory();
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// The outcome of a session.
struct PlayedSession {
  std::string trace;  // bytes of the file
  std::uint64_t tick_count = 0;
  play::View view;
  std::unique_ptr<play::PlayScene> playable;
  std::unique_ptr<engine::Engine> engine;  // state at the end
};

/// Plays `script` (JSON Lines, docs/play.md) in a picture of 800 x 600 px, shown `hz` times per second, and records to
/// `path`. `look` is called once per frame and may be empty.
PlayedSession play_script(const engine::Scene& scene, const std::string& script, double hz, const std::string& path,
                          const std::function<void(const engine::Engine&, const play::Session&)>& look = {});

std::string file_bytes(const std::string& path);

/// The built-in scene; fails the test if there is none with this name.
engine::Scene builtin_scene(const char* text);

/// Records `tick_count` ticks of the scene. At the end of tick `flip_tick`, the lowest bit of a value of a body flips
/// in the recorded run. This build therefore cannot repeat the trace. If `flip_tick` is after the end, no bit flips.
void record_flipped(const engine::Scene& scene, std::uint64_t tick_count, std::uint64_t flip_tick, std::uint32_t body,
                    const tool::TraceChoices& choices, const std::string& path);

}  // namespace ticktrue::test
