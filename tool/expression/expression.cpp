// Expressions by muParser.
// SPDX-License-Identifier: MIT
#include "tool/expression/expression.h"

#ifdef TICKTRUE_HAS_MUPARSER
#include <muParser.h>
#endif

#include <algorithm>
#include <array>
#include <deque>
#include <optional>
#include <string_view>

#include "engine/math/trig.h"
#include "tool/expression/named_values.h"
#include "tool/study/table.h"

namespace ticktrue::tool {

#ifdef TICKTRUE_HAS_MUPARSER

/// With its present value.
struct UsedName {
  NamedValue named;
  double now = 0;
};

struct Expression::Parser {
  mu::Parser parser;
  std::string text;
  std::array<double, world_values.size()> now{};    // [value]
  std::array<double, world_values.size()> start{};  // [value]
  std::vector<WorldValue> used;                     // ascending
  std::vector<WorldValue> used_at_start;
  std::deque<UsedName> parts;  // in the order in which they are named
  double time_s = 0;

  /// Before the text is set.
  void define(ExpressionNames names);
  /// After it.
  void find_used();
};

namespace {

constexpr const char* start_suffix = "_start";

std::string name_of(WorldValue value) {
  return std::string(world_values[static_cast<std::size_t>(value)].name);
}

std::string known_names(ExpressionNames names) {
  if (names == ExpressionNames::time)
    return "names: t, the time in s, and pi; sin, cos, exp, sqrt, abs, min, max; a*b is a product, a^b a power";
  std::string text;
  for (const WorldValueInfo& info : world_values) text += (text.empty() ? "" : ", ") + std::string(info.name);
  if (names == ExpressionNames::world) return "names: " + text + "; with _start: before the first tick";
  return "names: " + text + "; " + named_values_text();
}

constexpr const char* name_characters = "0123456789_.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

/// Of each name of a body, contact or joint in the text, one.
std::deque<UsedName> find_parts(const std::string& text) {
  std::deque<UsedName> parts;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find_first_of(name_characters, at);
    if (begin == std::string::npos) break;
    at = std::min(text.find_first_not_of(name_characters, begin), text.size());
    std::optional<NamedValue> named = find_named_value(std::string_view(text).substr(begin, at - begin));
    const auto is_same = [&](const UsedName& other) { return other.named.name == named->name; };
    if (named && std::none_of(parts.begin(), parts.end(), is_same)) parts.push_back({*std::move(named)});
  }
  return parts;
}

/// An assignment changes a value of the world for the rest of the expression: nobody means that.
bool has_assignment(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const bool is_second = i > 0 && std::string("=<>!").find(text[i - 1]) != std::string::npos;
    const bool is_first = i + 1 < text.size() && text[i + 1] == '=';
    if (!is_first && !is_second) return true;
  }
  return false;
}

}  // namespace

void Expression::Parser::define(ExpressionNames names) {
  if (names == ExpressionNames::time) {
    parser.DefineVar("t", &time_s);
    parser.DefineConst("pi", engine::pi);
    return;
  }
  for (const WorldValueInfo& info : world_values) {
    const auto index = static_cast<std::size_t>(info.value);
    const std::string name(info.name);
    parser.DefineVar(name, &now[index]);
    parser.DefineVar(name + start_suffix, &start[index]);
  }
  if (names != ExpressionNames::world_and_parts) return;
  parser.DefineNameChars(name_characters);
  parts = find_parts(text);
  for (UsedName& part : parts) parser.DefineVar(part.named.name, &part.now);
}

void Expression::Parser::find_used() {
  const auto& names = parser.GetUsedVar();
  for (const WorldValueInfo& info : world_values) {
    if (names.count(std::string(info.name)) != 0) used.push_back(info.value);
    if (names.count(std::string(info.name) + start_suffix) != 0) used_at_start.push_back(info.value);
  }
}

Result<Expression> Expression::parse(const std::string& text, const std::string& option, ExpressionNames names) {
  const auto wrong = [&](const std::string& what, const std::string& hint) {
    return Error{ErrorCode::usage, option + ": \"" + text + "\": " + what, hint};
  };
  if (has_assignment(text)) return wrong("found an assignment, expected an expression", "== compares");
  auto parser = std::make_unique<Parser>();
  parser->text = text;
  try {
    parser->define(names);
    parser->parser.SetExpr(text);
    parser->find_used();
    parser->parser.Eval();
    if (parser->parser.GetNumResults() != 1) return wrong("found several expressions, expected one", "");
  } catch (const mu::Parser::exception_type& error) {
    return wrong(error.GetMsg(), known_names(names));
  }
  return Expression(std::move(parser));
}

void Expression::begin(const engine::Engine& engine) {
  WorldMeasures measures(engine);
  for (const WorldValue value : parser_->used_at_start)
    parser_->start[static_cast<std::size_t>(value)] = measures.of(value);
}

double Expression::evaluate(const engine::Engine& engine) {
  WorldMeasures measures(engine);
  for (const WorldValue value : parser_->used) parser_->now[static_cast<std::size_t>(value)] = measures.of(value);
  NamedValues values(engine);
  for (UsedName& part : parser_->parts) part.now = values.of(part.named);
  return parser_->parser.Eval();
}

double Expression::evaluate_at(double time_s) {
  parser_->time_s = time_s;
  return parser_->parser.Eval();
}

Status Expression::check_parts(const engine::Scene& scene, const std::string& place) const {
  for (const UsedName& part : parser_->parts)
    if (const Status exists = check_exists(part.named, scene, place); !exists) return exists;
  return {};
}

bool Expression::uses_start() const {
  return !parser_->used_at_start.empty();
}

std::string Expression::values_text() const {
  std::string text;
  const auto add = [&](const std::string& name, double value) {
    text += (text.empty() ? "" : ", ") + name + " = " + short_number(value);
  };
  for (const WorldValue value : parser_->used) add(name_of(value), parser_->now[static_cast<std::size_t>(value)]);
  for (const WorldValue value : parser_->used_at_start)
    add(name_of(value) + start_suffix, parser_->start[static_cast<std::size_t>(value)]);
  for (const UsedName& part : parser_->parts) add(part.named.name, part.now);
  return text;
}

#else

struct Expression::Parser {
  std::string text;
  std::vector<WorldValue> used;
};

Result<Expression> Expression::parse(const std::string& text, const std::string& option, ExpressionNames) {
  return Error{ErrorCode::unsupported, option + ": \"" + text + "\": this build evaluates no expressions",
               "build ticktrue with muParser: apt-get install libmuparser-dev"};
}
void Expression::begin(const engine::Engine&) {}
double Expression::evaluate(const engine::Engine&) {
  return 0;
}
double Expression::evaluate_at(double) {
  return 0;
}
Status Expression::check_parts(const engine::Scene&, const std::string&) const {
  return {};
}
bool Expression::uses_start() const {
  return false;
}
std::string Expression::values_text() const {
  return "";
}

#endif

Expression::Expression(std::unique_ptr<Parser> parser) : parser_(std::move(parser)) {}
Expression::Expression(Expression&& other) noexcept = default;
Expression& Expression::operator=(Expression&& other) noexcept = default;
Expression::~Expression() = default;

const std::vector<WorldValue>& Expression::values() const {
  return parser_->used;
}

const std::string& Expression::text() const {
  return parser_->text;
}

}  // namespace ticktrue::tool
