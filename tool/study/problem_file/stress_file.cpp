// Reads users' stress cases.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/stress_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "engine/json/number_text.h"
#include "engine/scene/choices.h"
#include "engine/scene/json_reader.h"
#include "tool/expression/expression.h"
#include "tool/output/json_output.h"
#include "tool/session/scene_key.h"
#include "tool/study/measures.h"
#include "tool/study/problem_file/problem_scene.h"
#include "tool/study/stress/stress_parts.h"
#include "tool/study/table.h"

namespace ticktrue::tool {
namespace {

using engine::JsonPath;
using engine::JsonValue;
using engine::Precision;
using engine::Scene;

constexpr std::size_t case_count_max = 1000;
constexpr double tick_count_max = 1e8;

/// How the values after the ticks of a run become one value.
enum class Over : std::uint8_t { largest, least, end };
constexpr std::array<engine::Choice<Over>, 3> overs{{
    {Over::largest, "largest", "the largest after any tick"},
    {Over::least, "least", "the least after any tick"},
    {Over::end, "end", "that after the last tick"},
}};

struct StressText {
  std::string name;
  std::string what;
  const JsonValue* scene = nullptr;
  double duration = 0;
  double from = 0;
  std::string measure;
  Over over = Over::largest;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  std::string unit;
  std::vector<std::string> vary;
  std::vector<std::string> methods;  // judged
  std::vector<std::string> beside;   // shown beside them
};

class StressReader final : public OwnFileReader {
 public:
  using OwnFileReader::OwnFileReader;

  bool read_all(const JsonValue& root, StressText& out) {
    const JsonPath path;
    const auto text = [this](std::string& into) {
      return [this, &into](const JsonValue& v, const JsonPath& p) { return read(v, p, into); };
    };
    const auto texts = [this](std::vector<std::string>& into) {
      return [this, &into](const JsonValue& v, const JsonPath& p) { return read_texts(v, p, into); };
    };
    const auto number = [this](double& into) {
      return [this, &into](const JsonValue& v, const JsonPath& p) { return read(v, p, into); };
    };
    std::string schema;  // for editors
    const std::vector<Field> fields{
        {"$schema", text(schema)},
        {"name", text(out.name)},
        {"what", text(out.what)},
        {"scene", [&](const JsonValue& v, const JsonPath&) { return (out.scene = &v) != nullptr; }, true},
        {"duration", [&](const JsonValue& v, const JsonPath& p) { return read_duration(v, p, out.duration); }, true},
        {"from", number(out.from)},
        {"measure", text(out.measure), true},
        {"over", [&](const JsonValue& v, const JsonPath& p) { return choice(v, p, overs, out.over); }},
        {"lower", number(out.lower)},
        {"upper", number(out.upper)},
        {"unit", text(out.unit)},
        {"vary", texts(out.vary)},
        {"methods", texts(out.methods)},
        {"beside", texts(out.beside)},
    };
    if (!is_own_kind(root, "ticktrue stress", "observe", "ticktrue accuracy") || !object(root, path, fields))
      return false;
    if (!(out.from >= 0 && out.from < out.duration))
      return fail({&path, "from"}, "found " + engine::number_text(out.from) + ", expected 0 or more, below duration");
    if (std::isinf(out.lower) && std::isinf(out.upper))
      return fail(path, "found neither lower nor upper, expected a bound");
    if (out.lower > out.upper)
      return fail({&path, "lower"}, "found " + engine::number_text(out.lower) + ", expected at most upper");
    return true;
  }
};

/// The measure that a file defines for each run.
struct Measured {
  std::string measure;
  std::string place;  // place to name in messages
  Over over = Over::largest;
  double duration = 0;  // s
  double from = 0;      // s
};

/// Runs the scene, and evaluates the measure after each tick from `from` on. Returns the value that `over` selects.
StressValue run_measured(const Scene& scene, const Measured& measured) {
  StressValue out;
  out.ran_in = scene.settings.precision;
  Result<Run> run = Run::make(scene);
  if (!run) {
    out.why_not = run.error().message;
    return out;
  }
  Result<Expression> expression = Expression::parse(measured.measure, measured.place, ExpressionNames::world_and_parts);
  if (!expression) {
    out.why_not = expression.error().message;
    return out;
  }
  expression->begin(run->engine());
  const auto tick_count = static_cast<std::uint64_t>(std::ceil(measured.duration / scene.settings.dt - 1e-9));
  bool is_first = true;
  for (std::uint64_t tick = 1; tick <= tick_count; ++tick) {
    if (const Status did = run->advance(1); !did) {
      out.why_undone = did.error().message;
      return out;
    }
    const bool is_last = tick == tick_count;
    if (!is_last && (measured.over == Over::end || run->engine().time_s() < measured.from)) continue;
    const double value = expression->evaluate(run->engine());
    if (is_first || measured.over == Over::end || std::isnan(value))
      out.value = value;
    else
      out.value = measured.over == Over::largest ? std::max(out.value, value) : std::min(out.value, value);
    is_first = false;
    out.is_finite = std::isfinite(value) && all_finite(run->bodies());
    if (!out.is_finite) return out;
  }
  return out;
}

/// Errors: usage (too many ticks, a measure without a value before the first tick); those of make_engine.
Status check_run(const Scene& scene, const Measured& measured, StressReader& reader) {
  const double ticks = measured.duration / scene.settings.dt;
  if (!(ticks <= tick_count_max))
    return reader.error_at("duration", "found " + engine::number_text(measured.duration) + " s of ticks of " +
                                           engine::number_text(scene.settings.dt) + " s, expected at most 1e8 ticks");
  const auto engine = engine::make_engine(scene);
  if (!engine) return engine.error();
  Result<Expression> expression = Expression::parse(measured.measure, measured.place, ExpressionNames::world_and_parts);
  if (!expression) return expression.error();
  if (const Status exists = expression->check_parts(scene, measured.place); !exists) return exists;
  expression->begin(**engine);
  const double value = expression->evaluate(**engine);
  if (std::isfinite(value)) return {};
  return reader.error_at("measure", "found " + short_number(value) + " before the first tick, expected a finite number",
                         "bodies.3.x is that of the body with id 3; ids count from 0 in the order of the scene");
}

/// The name of the method that runs the scene unchanged, apart from a requested precision.
constexpr std::string_view as_stated = "scene";

Result<std::vector<StressMethod>> methods_of(const StressText& text, const Scene& scene, StressReader& reader) {
  std::vector<StressMethod> known;
  StressMethod own;
  own.name = as_stated;
  known.push_back(own);
  const bool is_free = scene.settings.solver == engine::SolverKind::free_flight;
  for (StressMethod& method : is_free ? integrator_methods() : joint_methods()) known.push_back(std::move(method));
  if (!is_free) known.push_back(contact_methods().back());
  std::vector<StressMethod> chosen;
  const auto add = [&](const char* key, const std::vector<std::string>& chosen_names, bool is_baseline) -> Status {
    std::vector<std::string_view> names;
    for (const StressMethod& method : known) names.push_back(method.name);
    for (const std::string& name : chosen_names) {
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end())
        return reader.error_at(key, "found " + engine::in_quotes(name) + ", expected " + engine::listed(names));
      chosen.push_back(known[static_cast<std::size_t>(found - names.begin())]);
      chosen.back().is_baseline = is_baseline;
    }
    return {};
  };
  std::vector<std::string> others;
  if (text.methods.empty() && text.beside.empty())
    for (const StressMethod& method : known)
      if (method.name != as_stated) others.push_back(method.name);
  const std::vector<std::string> judged = text.methods.empty() ? std::vector{std::string(as_stated)} : text.methods;
  if (const Status done = add("methods", judged, false); !done) return done.error();
  if (const Status done = add("beside", others.empty() ? text.beside : others, true); !done) return done.error();
  return chosen;
}

/// A scene with one value for each varied key, and the suffix of its name.
struct VariedScene {
  std::string suffix;
  Scene scene;
  bool varies_precision = false;
};
Result<std::vector<VariedScene>> varied_scenes(const StressText& text, const Scene& scene, const std::string& place) {
  std::vector<VariedKey> keys;
  for (const std::string& vary : text.vary) {
    Result<VariedKey> varied = parse_varied(vary, place);
    if (!varied) return varied.error();
    keys.push_back(*std::move(varied));
  }
  if (const Status are_apart = check_apart(keys, scene, place); !are_apart) return are_apart.error();
  std::vector<VariedScene> scenes{{"", scene, false}};
  for (const VariedKey& varied : keys) {
    std::vector<VariedScene> more;
    for (const VariedScene& each : scenes)
      for (const std::string& value : varied.values) {
        const Result<Scene> changed = scene_with(each.scene, varied.key, value, place);
        if (!changed) return changed.error();
        const bool varies_precision = each.varies_precision || varied.key == "settings.precision";
        more.push_back({each.suffix + " " + varied.key + "=" + value, *changed, varies_precision});
        if (more.size() > case_count_max)
          return Error{ErrorCode::usage,
                       place + ": found more than " + std::to_string(case_count_max) + " cases, expected fewer", ""};
      }
    scenes = std::move(more);
  }
  return scenes;
}

}  // namespace

const char* const example_stress = R"({
  "name": "loaded",
  "what": "four boxes under one that is heavier: deepest overlap over the size of a box, from 2 s on",
  "scene": "stack?boxes=5",
  "vary": "bodies.5.shapes.0.density=1,100,1000",
  "duration": 10,
  "from": 2,
  "measure": "overlap / 1.0",
  "upper": 0.05,
  "methods": "tgs_soft auto",
  "beside": ["tgs_soft", "pgs"]
}
)";

Result<std::vector<StressCase>> read_stress_file(const std::string& path) {
  const Result<std::string> json = cli::read_text_file(path, problem_file_size_max);
  if (!json) return json.error();
  const Result<JsonValue> tree = engine::parse_json(*json, path, ErrorCode::usage);
  if (!tree) return tree.error();
  StressText text;
  StressReader reader(path);
  if (!reader.read_all(*tree, text)) return reader.error();
  const Result<Scene> scene = scene_of_problem(*text.scene, *json, path);
  if (!scene) return scene.error();
  const Result<std::vector<StressMethod>> methods = methods_of(text, *scene, reader);
  if (!methods) return methods.error();
  const Measured measured{text.measure, path + ": measure", text.over, text.duration, text.from};
  Result<std::vector<VariedScene>> scenes = varied_scenes(text, *scene, path + ": vary");
  if (!scenes) return scenes.error();
  for (const VariedScene& each : *scenes)
    if (const Status fits = check_run(each.scene, measured, reader); !fits) return fits.error();
  std::vector<StressCase> cases;
  for (VariedScene& each : *scenes) {
    StressCase made;
    made.name = (text.name.empty() ? std::filesystem::path(path).stem().string() : text.name) + each.suffix;
    made.what = text.what.empty() ? text.measure : text.what;
    made.unit = text.unit;
    made.lower = text.lower;
    made.upper = text.upper;
    made.methods = *methods;
    made.is_own = true;
    made.usual = each.scene.settings.precision;
    made.varies_precision = each.varies_precision;
    made.run = [measured, own = std::move(each.scene)](const StressMethod& method, Precision precision) {
      Scene run = method.name == as_stated ? own : with_method(own, method);
      run.settings.precision = precision;
      return run_measured(run, measured);
    };
    cases.push_back(std::move(made));
  }
  return cases;
}

}  // namespace ticktrue::tool
