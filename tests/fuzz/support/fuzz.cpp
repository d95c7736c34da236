// Properties, files in memory and small worlds for the fuzz harnesses.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/support/fuzz.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "base/limits.h"

namespace ticktrue::fuzz {

void require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: this does not hold: %s\n", property);
  std::abort();
}

void require_message(const Error& error) {
  require(error.message.size() > 5, "a refusal says why");
  require(error.message.size() < 4'096, "a refusal is short");
}

MemoryFile::MemoryFile(ByteView bytes) : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
  require(descriptor_ >= 0, "memfd_create works");
  require(::write(descriptor_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()), "write works");
  path_ = "/proc/self/fd/" + std::to_string(descriptor_);
}
MemoryFile::~MemoryFile() {
  ::close(descriptor_);
}

bool is_small(const engine::Scene& scene) {
  constexpr std::size_t part_count_max = 40;
  constexpr int work_max = 8'000;  // parts times passes
  std::size_t part_count = scene.bodies.size() + scene.prototypes.size() + scene.joints.size() + scene.forces.size();
  for (const auto* bodies : {&scene.bodies, &scene.prototypes})
    for (const engine::Body& body : *bodies)
      for (const engine::Shape& shape : body.shapes) part_count += 1 + shape.vertices.size();
  if (part_count > part_count_max) return false;
  const int substeps = scene.settings.auto_substeps ? limits::substep_count_max : scene.settings.substeps;
  const int passes = substeps + scene.settings.iterations;
  return static_cast<int>(part_count + 1) * passes <= work_max;
}

void run_a_little(engine::Engine& engine, double dt, int tick_count) {
  for (int tick = 0; tick < tick_count; ++tick) {
    const TickInput input{dt, {}};
    if (!engine.accept(input)) return;
    if (const Status did = engine.step(input, nullptr); !did) return require_message(did.error());
    if (find_non_finite(engine.state())) return;
  }
  Bytes image;
  encode_image(engine.state(), image);
  require(engine.load(image).has_value(), "a finite state loads again");
  Bytes again;
  encode_image(engine.state(), again);
  require(image == again, "a state that was loaded is the same state");
}

}  // namespace ticktrue::fuzz
