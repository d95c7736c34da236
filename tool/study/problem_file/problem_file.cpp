// Reads a user's verification problem.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/problem_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>

#include "base/limits.h"
#include "engine/json/number_text.h"
#include "engine/scene/json_reader.h"
#include "engine/scene/scene_json.h"
#include "tool/expression/expression.h"
#include "tool/output/json_output.h"
#include "tool/study/accuracy.h"
#include "tool/study/problem_file/problem_scene.h"
#include "tool/study/problem_file/reference_table.h"
#include "tool/study/table.h"

namespace ticktrue::tool {
namespace {

using engine::JsonPath;
using engine::JsonValue;
using engine::number_text;
using engine::Precision;
using engine::Scene;

constexpr engine::FieldRange sample_range{1, 10'000};
constexpr engine::FieldRange substep_range{1, limits::substep_count_max};
constexpr std::size_t slope_setting_least = 3;
// Values that differ more are of different kinds, or one of them hardly matters to a common scale.
constexpr double scale_ratio_most = 3;

/// The contents of the file.
struct ProblemText {
  std::string name;
  std::string summary;
  const JsonValue* scene = nullptr;
  double duration = 0;
  int sample_count = 20;
  std::vector<std::string> observe;
  std::vector<std::string> exact;
  std::string reference;
  bool is_angle = false;
  std::vector<double> scales;  // one for all, or one for each observed value
  double size = 0;
  std::vector<std::string> methods;
  std::vector<int> substeps;
  std::optional<double> slope;
  std::optional<double> slope_of_higher;
  std::vector<std::pair<std::string, double>> slopes;
  std::vector<Bar> bars;
};

class ProblemReader final : public OwnFileReader {
 public:
  using OwnFileReader::OwnFileReader;

  bool read_all(const JsonValue& root, ProblemText& out) {
    const JsonPath path;
    const auto texts = [this](std::vector<std::string>& list) {
      return [this, &list](const JsonValue& v, const JsonPath& p) { return read_texts(v, p, list); };
    };
    const auto text = [this](std::string& into) {
      return [this, &into](const JsonValue& v, const JsonPath& p) { return read(v, p, into); };
    };
    std::string schema;  // for editors
    const std::vector<Field> fields{
        {"$schema", text(schema)},
        {"name", text(out.name)},
        {"summary", text(out.summary)},
        {"scene", [&](const JsonValue& v, const JsonPath&) { return (out.scene = &v) != nullptr; }, true},
        {"duration", [&](const JsonValue& v, const JsonPath& p) { return read_duration(v, p, out.duration); }, true},
        whole("samples", sample_range, out.sample_count),
        {"observe", texts(out.observe), true},
        {"exact", texts(out.exact)},
        {"reference", text(out.reference)},
        {"angle", [&](const JsonValue& v, const JsonPath& p) { return read(v, p, out.is_angle); }},
        {"scale", [&](const JsonValue& v, const JsonPath& p) { return read_scales(v, p, out.scales); }},
        {"size", [&](const JsonValue& v, const JsonPath& p) { return positive(v, p, out.size); }},
        {"methods", texts(out.methods)},
        {"substeps", [&](const JsonValue& v, const JsonPath& p) { return read_substeps(v, p, out.substeps); }},
        {"slope", [&](const JsonValue& v, const JsonPath& p) { return read_slope(v, p, out); }},
        {"bars",
         [&](const JsonValue& v, const JsonPath& p) {
           return list(v, p, out.bars, [&](const auto& e, const auto& q, Bar& bar) { return read_bar(e, q, bar); });
         }},
    };
    if (!is_own_kind(root, "ticktrue accuracy", "measure", "ticktrue stress") || !object(root, path, fields))
      return false;
    if (out.observe.empty()) return fail({&path, "observe"}, "found nothing, expected an expression");
    if (out.exact.empty() == out.reference.empty())
      return fail(path, std::string("found ") + (out.exact.empty() ? "neither exact nor" : "both exact and") +
                            " reference, expected one of them");
    if (!out.exact.empty() && out.exact.size() != out.observe.size())
      return fail({&path, "exact"}, "found " + std::to_string(out.exact.size()) + " expressions, expected " +
                                        std::to_string(out.observe.size()) + ", as in observe");
    if (out.scales.size() > 1 && out.scales.size() != out.observe.size())
      return fail({&path, "scale"}, "found " + std::to_string(out.scales.size()) + " numbers, expected one, or " +
                                        std::to_string(out.observe.size()) + ", as in observe");
    if (out.scales.size() > 1 && (out.is_angle || out.size > 0))
      return fail({&path, "scale"}, "found several numbers, expected one: the file has angle or size");
    return true;
  }

 private:
  bool read_scales(const JsonValue& value, const JsonPath& path, std::vector<double>& out) {
    if (value.type != JsonValue::Type::array) return positive(value, path, out.emplace_back());
    const auto read_one = [&](const auto& v, const auto& p, double& scale) { return positive(v, p, scale); };
    return list(value, path, out, read_one) &&
           (!out.empty() || fail(path, "found nothing, expected one number, or one for each value of observe"));
  }

  /// Reads one slope for all integrators, [of order 1, of higher order], or {method: slope}.
  bool read_slope(const JsonValue& value, const JsonPath& path, ProblemText& out) {
    if (value.type == JsonValue::Type::object) {
      for (std::size_t i = 0; i < value.items.size(); ++i) {
        double& slope = out.slopes.emplace_back(value.keys[i], 0).second;
        if (!read(value.items[i], {&path, value.keys[i]}, slope)) return false;
      }
      return !out.slopes.empty() || fail(path, "found nothing, expected methods with their slopes");
    }
    if (value.type != JsonValue::Type::array) return read(value, path, out.slope.emplace());
    return pair(value, path, "[of order 1, of higher order]", out.slope.emplace(), out.slope_of_higher.emplace());
  }

  bool read_substeps(const JsonValue& value, const JsonPath& path, std::vector<int>& out) {
    const auto read_one = [&](const auto& v, const auto& p, int& count) { return whole(v, p, substep_range, count); };
    if (!list(value, path, out, read_one)) return false;
    for (std::size_t i = 1; i < out.size(); ++i)
      if (out[i] <= out[i - 1])
        return fail({&path, {}, i}, "found " + std::to_string(out[i]) + ", expected more than before");
    return !out.empty() || fail(path, "found nothing, expected counts from coarse to fine");
  }

  bool read_bar(const JsonValue& value, const JsonPath& path, Bar& bar) {
    const std::vector<Field> fields{
        {"method", [&](const JsonValue& v, const JsonPath& p) { return read(v, p, bar.method); }, true},
        {"at", [&](const JsonValue& v, const JsonPath& p) { return read(v, p, bar.setting); }},
        {"error", [&](const JsonValue& v, const JsonPath& p) { return positive(v, p, bar.error); }},
        {"energy", [&](const JsonValue& v, const JsonPath& p) { return positive(v, p, bar.energy); }},
    };
    if (!object(value, path, fields)) return false;
    return bar.error > 0 || bar.energy > 0 || fail(path, "found no bar, expected error or energy");
  }
};

/// Expressions that several threads share; one thread uses them at a time.
struct SharedExpressions {
  std::mutex mutex;
  std::vector<Expression> list;

  template <typename Evaluate>
  std::vector<double> values(Evaluate evaluate) {
    const std::lock_guard<std::mutex> lock(mutex);
    std::vector<double> out;
    for (Expression& expression : list) out.push_back(evaluate(expression));
    return out;
  }
};

Result<std::shared_ptr<SharedExpressions>> parse_all(const std::vector<std::string>& texts, const std::string& place,
                                                     ExpressionNames names) {
  auto shared = std::make_shared<SharedExpressions>();
  for (const std::string& text : texts) {
    Result<Expression> parsed = Expression::parse(text, place, names);
    if (!parsed) return parsed.error();
    if (names != ExpressionNames::time && parsed->uses_start())
      return Error{ErrorCode::usage, place + ": \"" + text + "\": found a name with _start, expected present values",
                   ""};
    shared->list.push_back(*std::move(parsed));
  }
  return shared;
}

/// Whether a scene has energy that energy_of does not count.
bool stores_other_energy(const Scene& scene) {
  const auto is_stored = [](const engine::Force& force) {
    return force.kind == engine::ForceKind::spring || force.kind == engine::ForceKind::central;
  };
  const auto has_spring = [](const engine::Joint& joint) { return joint.spring || joint.linear_spring; };
  return std::any_of(scene.forces.begin(), scene.forces.end(), is_stored) ||
         std::any_of(scene.joints.begin(), scene.joints.end(), has_spring);
}

class ProblemMaker {
 public:
  ProblemMaker(std::string path, std::string json, ProblemText text)
      : path_(std::move(path)), json_(std::move(json)), text_(std::move(text)), reader_(path_) {}

  Result<Problem> make() {
    Problem problem;
    problem.name = text_.name.empty() ? std::filesystem::path(path_).stem().string() : text_.name;
    problem.summary = text_.summary.empty() ? path_ : text_.summary;
    problem.reference = text_.reference.empty() ? "an expression of " + path_ : text_.reference;
    problem.duration = text_.duration;
    problem.sample_count = text_.sample_count;
    problem.is_angle = text_.is_angle;
    problem.size = text_.size;
    problem.method_names = text_.methods;
    problem.substep_counts = text_.substeps;
    problem.bars = text_.bars;
    problem.slope = text_.slope;
    problem.slope_of_higher = text_.slope_of_higher;
    problem.slopes = text_.slopes;
    problem.is_own = true;
    if (!text_.slope) problem.why_no_slope = path_ + " states no slope";
    for (const auto step : {&ProblemMaker::add_scene, &ProblemMaker::add_observe, &ProblemMaker::add_exact,
                            &ProblemMaker::add_scales, &ProblemMaker::check_sweep, &ProblemMaker::check_methods})
      if (const Status done = (this->*step)(problem); !done) return done.error();
    return problem;
  }

 private:
  Status add_scene(Problem& problem) {
    const Result<Scene> read = scene_of_problem(*text_.scene, json_, path_);
    if (!read) return read.error();
    const Scene& scene = *read;
    problem.scene = [scene](Precision precision) {
      Scene out = scene;
      out.settings.precision = precision;
      return out;
    };
    problem.dt = scene.settings.dt;
    const bool is_free = scene.settings.solver == engine::SolverKind::free_flight;
    problem.kind = is_free ? ProblemClass::smooth : ProblemClass::joint;
    if (is_free) {
      // The coarsest run has about the step of the scene. Every sample is at the end of a tick.
      const double ticks = std::ceil(problem.duration / problem.dt / problem.sample_count);
      problem.step_count = problem.sample_count * static_cast<int>(std::clamp(ticks, 1.0, 1000.0));
      return {};
    }
    const double ticks = problem.duration / problem.dt / problem.sample_count;
    if (ticks < 0.5 || std::fabs(ticks - std::round(ticks)) > 1e-6)
      return reader_.error_at("samples",
                              "found " + std::to_string(problem.sample_count) + " in " + number_text(problem.duration) +
                                  " s, expected each at the end of a tick of " + number_text(problem.dt) + " s",
                              "duration / dt / samples must be a whole number");
    return {};
  }

  Status add_observe(Problem& problem) {
    const auto parsed = parse_all(text_.observe, path_ + ": observe", ExpressionNames::world_and_parts);
    if (!parsed) return parsed.error();
    problem.observe = [shared = *parsed](const engine::Engine& engine) {
      return shared->values([&](Expression& expression) { return expression.evaluate(engine); });
    };
    problem.value_names = text_.observe;
    const auto engine = engine::make_engine(problem.scene(Precision::f64));
    if (!engine) return engine.error();
    for (const Expression& expression : (*parsed)->list)
      if (const Status exists = expression.check_parts((*engine)->scene(), path_ + ": observe"); !exists) return exists;
    const std::vector<double> values = problem.observe(**engine);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        return reader_.error_at("observe",
                                "\"" + text_.observe[i] + "\": found " + short_number(values[i]) +
                                    " before the first tick, expected a finite number",
                                "bodies.3.x is that of the body with id 3; ids count from 0 in the order of the scene");
    return {};
  }

  Status add_exact(Problem& problem) {
    if (text_.exact.empty()) {
      if (const Status done = add_reference(problem); !done) return done;
    } else {
      const auto parsed = parse_all(text_.exact, path_ + ": exact", ExpressionNames::time);
      if (!parsed) return parsed.error();
      problem.exact = [shared = *parsed](double time_s) {
        return shared->values([&](Expression& expression) { return expression.evaluate_at(time_s); });
      };
    }
    return {};
  }

  /// Errors of several values are relative to one number, or each to its own.
  Status add_scales(Problem& problem) {
    std::vector<double> largest(text_.observe.size());  // of each value
    double largest_of_all = 0;
    for (int sample = 1; sample <= problem.sample_count; ++sample) {
      const double time_s = problem.duration * sample / problem.sample_count;
      const std::vector<double> values = problem.exact(time_s);
      double squares = 0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        squares += values[i] * values[i];
        largest[i] = std::max(largest[i], std::fabs(values[i]));
      }
      if (!std::isfinite(squares))
        return reader_.error_at("exact", "found a value that is not finite at " + number_text(time_s) + " s");
      largest_of_all = std::max(largest_of_all, std::sqrt(squares));
    }
    if (text_.scales.size() > 1) {
      divide_by_scales(problem);
      return {};
    }
    problem.scale = text_.scales.empty() ? largest_of_all : text_.scales[0];
    if (!(problem.scale > 0))
      return reader_.error_at("scale", "found none, and exact values of 0, expected what errors are relative to");
    const auto [least, most] = std::minmax_element(largest.begin(), largest.end());
    if (text_.scales.empty() && *least > 0 && *most > scale_ratio_most * *least)
      return reader_.error_at("scale",
                              "found none, and values of observe of up to " + short_number(*most) + " and of up to " +
                                  short_number(*least) + ", expected what errors are relative to",
                              "one number for all, or a list with one for each value of observe");
    return {};
  }

  /// Observed and exact values are divided, and the scale of all becomes 1.
  void divide_by_scales(Problem& problem) {
    const auto divided = [scales = text_.scales](std::vector<double> values) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] /= scales[i];
      return values;
    };
    problem.observe = [observe = problem.observe, divided](const engine::Engine& engine) {
      return divided(observe(engine));
    };
    problem.exact = [exact = problem.exact, divided](double time_s) { return divided(exact(time_s)); };
    problem.scale = 1;
    problem.value_scales = text_.scales;
  }

  Status check_sweep(Problem& problem) {
    if (problem.substep_counts.empty()) return {};
    if (problem.kind == ProblemClass::smooth)
      return reader_.error_at("substeps", "found with free_flight, whose sweep is over dt, expected none");
    const bool claims_slope = problem.slope || !problem.slopes.empty();
    if (claims_slope && problem.substep_counts.size() < slope_setting_least)
      return reader_.error_at("substeps", "found " + std::to_string(problem.substep_counts.size()) +
                                              " of them, expected at least 3: the file claims a slope");
    return {};
  }

  Status add_reference(Problem& problem) {
    const std::string file = (std::filesystem::path(path_).parent_path() / text_.reference).string();
    const Result<std::string> csv = cli::read_text_file(file, problem_file_size_max);
    if (!csv) return reader_.error_at("reference", csv.error().message, "it is searched in the folder of this file");
    const auto table = ReferenceTable::parse(*csv, file, text_.observe);
    if (!table) return table.error();
    const double first = problem.duration / problem.sample_count;
    const double tolerance = 1e-9 * problem.duration;
    if (table->first_time() > first + tolerance || table->last_time() < problem.duration - tolerance)
      return Error{ErrorCode::usage,
                   file + ": found times from " + number_text(table->first_time()) + " to " +
                       number_text(table->last_time()) + " s, expected " + number_text(first) + " to " +
                       number_text(problem.duration) + " s",
                   ""};
    problem.exact = [reference = *table](double time_s) { return reference.at(time_s); };
    return {};
  }

  Status check_methods(Problem& problem) {
    std::vector<std::string> names = std::move(problem.method_names);
    problem.method_names.clear();
    std::vector<std::string> known;
    for (const Method& method : methods_of(problem)) known.push_back(method.name);
    const auto check = [&](const char* key, const std::string& name) -> Status {
      if (std::find(known.begin(), known.end(), name) != known.end()) return {};
      return reader_.error_at(key, "found method " + engine::in_quotes(name) + ", expected " +
                                       engine::listed({known.begin(), known.end()}));
    };
    for (const std::string& name : names)
      if (const Status is_known = check("methods", name); !is_known) return is_known;
    problem.method_names = std::move(names);
    const std::vector<Method> run = methods_of(problem);
    for (const auto& [name, slope] : problem.slopes) {
      if (const Status is_known = check("slope", name); !is_known) return is_known;
      if (std::none_of(run.begin(), run.end(), [&name = name](const Method& method) { return method.name == name; }))
        return reader_.error_at("slope", "found a slope of " + name + ", which methods leaves out");
    }
    for (const Bar& bar : problem.bars) {
      if (const Status is_known = check("bars", bar.method); !is_known) return is_known;
      if (const Status is_run = check_bar(problem, bar); !is_run) return is_run;
    }
    return {};
  }

  /// Refuses a bar for a setting that no point has, because such a bar could never be missed.
  Status check_bar(const Problem& problem, const Bar& bar) {
    if (bar.energy > 0 && stores_other_energy(problem.scene(Precision::f64)))
      return reader_.error_at("bars", "found energy in a scene with springs or central forces, expected error",
                              "energy counts motion and gravity alone");
    std::vector<std::string> settings;
    for (const Method& method : methods_of(problem)) {
      if (method.name != bar.method) continue;
      for (const Setting& setting : settings_of(problem, method)) settings.push_back(setting_text(method, setting));
    }
    if (settings.empty())
      return reader_.error_at("bars", "found a bar of " + bar.method + ", which methods leaves out");
    if (bar.setting.empty() || std::find(settings.begin(), settings.end(), bar.setting) != settings.end()) return {};
    return reader_.error_at("bars", "found setting " + engine::in_quotes(bar.setting) + " of " + bar.method +
                                        ", expected " + engine::listed({settings.begin(), settings.end()}));
  }

  std::string path_;
  std::string json_;
  ProblemText text_;
  ProblemReader reader_;
};

}  // namespace

const char* const example_problem = R"({
  "name": "brake",
  "summary": "a box at 6 m/s stops by friction of 0.4 after 1.5 s",
  "scene": "slide?speed=6&friction=0.4",
  "duration": 2,
  "samples": 20,
  "observe": "bodies.1.x",
  "exact": "t < 1.5 ? 6*t - 2*t^2 : 4.5",
  "methods": ["tgs_soft", "tgs_soft verlet", "pgs"],
  "slope": [1, 2],
  "bars": [
    {"method": "tgs_soft", "at": "4 sub", "error": 0.01},
    {"method": "tgs_soft verlet", "error": 0.001}
  ]
}
)";

Result<Problem> read_problem(const std::string& path) {
  const Result<std::string> json = cli::read_text_file(path, problem_file_size_max);
  if (!json) return json.error();
  const Result<JsonValue> tree = engine::parse_json(*json, path, ErrorCode::usage);
  if (!tree) return tree.error();
  ProblemText text;
  ProblemReader reader(path);
  if (!reader.read_all(*tree, text)) return reader.error();
  return ProblemMaker(path, *json, std::move(text)).make();
}

}  // namespace ticktrue::tool
