// Records a session, and lets another program judge the trace.
// SPDX-License-Identifier: MIT
#include "replay/recorder.h"
#include "tool/experiment/reduce/predicate.h"
#include "tool/session/session.h"

namespace ticktrue::reduce {
namespace {

using Answer = Result<std::optional<Failure>>;

/// A longer recording only stores the whole state of the differing tick.
constexpr std::uint64_t body_ticks_max = 20'000;

class DiffersElsewhere : public Predicate {
 public:
  DiffersElsewhere(const OtherProgram& program, const EngineMaker& make) : program_(program), make_(make) {}
  std::vector<std::string> words() const override { return program_.words; }
  std::string show_line() const override { return program_.show_line; }
  std::string test_line() const override { return program_.test_line; }

  Answer examine(const SoakCase& session) override {
    tool::TraceChoices whole;
    whole.detail = replay::Detail::full;
    whole.full_last = session.tick_count;
    if (session.tick_count * session.scene.bodies.size() <= body_ticks_max) return judge(session, whole);
    tool::TraceChoices names;
    names.detail = replay::Detail::cells;
    Answer answer = judge(session, names);
    if (!answer || !*answer) return answer;
    SoakCase begin = session;
    begin.tick_count = (*answer)->tick + 1;
    whole.full_first = whole.full_last = (*answer)->tick;
    return judge(begin, whole);
  }

 private:
  Answer judge(const SoakCase& session, const tool::TraceChoices& choices) const {
    const std::string trace = program_.folder + "/session.ttr";
    const auto made = make_(session.scene, {});
    if (!made) return made.error();
    const soak::CaseInputs inputs(session);
    soak::CaseSource source(inputs, session.tick_count);
    replay::RecordOptions options;
    options.writer.overwrite = true;
    options.writer.compress = false;
    options.writer.sync = false;
    const auto recorded = replay::record(**made, source, trace, tool::make_trace_setup(**made, choices),
                                         tool::make_build_facts(), options);
    if (!recorded) return recorded.error();
    Answer answer = program_.judge(trace);
    if (answer && *answer) add_bodies_of_joint(session, **answer);
    return answer;
  }

  static void add_bodies_of_joint(const SoakCase& session, Failure& failure) {
    if (failure.table != "joints" || !failure.row || *failure.row >= session.scene.joints.size()) return;
    const engine::Joint& joint = session.scene.joints[*failure.row];
    engine::for_each_body(session.scene, joint, [&](std::uint32_t body) { failure.bodies.push_back(body); });
  }

  OtherProgram program_;
  EngineMaker make_;
};

}  // namespace

std::unique_ptr<Predicate> differs_elsewhere(const OtherProgram& program, const EngineMaker& make) {
  return std::make_unique<DiffersElsewhere>(program, make);
}

}  // namespace ticktrue::reduce
