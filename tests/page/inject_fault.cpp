// Records a trace's session again with one flipped bit, like a build that computes differently.
// SPDX-License-Identifier: MIT
//
// inject_fault IN.ttr OUT.ttr TICK BODY BIT root|cells|full:A..B
// At the end of the tick, BIT of lane 0 of the velocity of the body in row BODY is flipped.
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

#include "replay/recorder.h"
#include "replay/trace_reader.h"
#include "tests/support/faulty_engine.h"
#include "tool/session/playback.h"
#include "tool/session/session.h"
#include "verifier/verify/trace_inputs.h"

namespace {

using namespace ticktrue;
using test::Fault;
using test::FaultyEngine;

int fail(const std::string& text) {
  std::fprintf(stderr, "inject_fault: error: %s\n", text.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) return fail("usage: inject_fault IN.ttr OUT.ttr TICK BODY BIT root|cells|full:A..B");
  auto reader = replay::TraceReader::open(argv[1]);
  if (!reader) return fail(reader.error().message);
  const auto scene = tool::scene_of(reader->setup());
  if (!scene) return fail(scene.error().message);
  const auto made = engine::make_engine(*scene);
  if (!made) return fail(made.error().message);
  const Fault fault{std::strtoull(argv[3], nullptr, 10), std::strtoull(argv[4], nullptr, 10),
                    static_cast<unsigned>(std::strtoul(argv[5], nullptr, 10))};

  tool::TraceChoices choices;
  choices.checkpoint_interval = reader->setup().checkpoint_interval;
  const std::string detail = argv[6];
  if (detail == "cells") choices.detail = replay::Detail::cells;
  if (detail.compare(0, 5, "full:") == 0) {
    choices.detail = replay::Detail::full;
    choices.full_first = std::strtoull(detail.c_str() + 5, nullptr, 10);
    choices.full_last = std::strtoull(detail.c_str() + detail.find("..") + 2, nullptr, 10);
  }
  const replay::TraceSetup setup = tool::make_trace_setup(**made, choices);
  FaultyEngine faulty(**made, fault);
  verifier::TraceInputs inputs(std::move(*reader));
  replay::RecordOptions options;
  options.writer.sync = false;
  const auto recorded = replay::record(faulty, inputs, argv[2], setup, tool::make_build_facts(), options);
  return recorded ? 0 : fail(recorded.error().message);
}
