// Expressions by muParser.
// SPDX-License-Identifier: MIT
#include "tool/expression/expression.h"

#ifdef TICKTRUE_HAS_MUPARSER
#include <muParser.h>
#endif

#include <array>

#include "tool/study/table.h"

namespace ticktrue::verifier {

#ifdef TICKTRUE_HAS_MUPARSER

struct Expression::Parser {
  mu::Parser parser;
  std::string text;
  std::array<double, world_values.size()> now{};    // [value]
  std::array<double, world_values.size()> start{};  // [value]
  std::vector<WorldValue> used;                     // ascending
  std::vector<WorldValue> used_at_start;
};

namespace {

constexpr const char* start_suffix = "_start";

std::string name_of(WorldValue value) {
  return std::string(world_values[static_cast<std::size_t>(value)].name);
}

std::string all_names() {
  std::string names;
  for (const WorldValueInfo& info : world_values) names += (names.empty() ? "" : ", ") + std::string(info.name);
  return names;
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

Result<Expression> Expression::parse(const std::string& text, const std::string& option) {
  const auto wrong = [&](const std::string& what, const std::string& hint) {
    return Error{ErrorCode::usage, option + ": \"" + text + "\": " + what, hint};
  };
  if (has_assignment(text)) return wrong("found an assignment, expected an expression", "== compares");
  auto parser = std::make_unique<Parser>();
  parser->text = text;
  try {
    for (const WorldValueInfo& info : world_values) {
      const auto index = static_cast<std::size_t>(info.value);
      const std::string name(info.name);
      parser->parser.DefineVar(name, &parser->now[index]);
      parser->parser.DefineVar(name + start_suffix, &parser->start[index]);
    }
    parser->parser.SetExpr(text);
    const auto& names = parser->parser.GetUsedVar();
    for (const WorldValueInfo& info : world_values) {
      if (names.count(std::string(info.name)) != 0) parser->used.push_back(info.value);
      if (names.count(std::string(info.name) + start_suffix) != 0) parser->used_at_start.push_back(info.value);
    }
    parser->parser.Eval();
    if (parser->parser.GetNumResults() != 1) return wrong("found several expressions, expected one", "");
  } catch (const mu::Parser::exception_type& error) {
    return wrong(error.GetMsg(), "names: " + all_names() + "; with _start: before the first tick");
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
  return parser_->parser.Eval();
}

std::string Expression::values_text() const {
  std::string text;
  const auto add = [&](const std::string& name, double value) {
    text += (text.empty() ? "" : ", ") + name + " = " + short_number(value);
  };
  for (const WorldValue value : parser_->used) add(name_of(value), parser_->now[static_cast<std::size_t>(value)]);
  for (const WorldValue value : parser_->used_at_start)
    add(name_of(value) + start_suffix, parser_->start[static_cast<std::size_t>(value)]);
  return text;
}

#else

struct Expression::Parser {
  std::string text;
  std::vector<WorldValue> used;
};

Result<Expression> Expression::parse(const std::string& text, const std::string& option) {
  return Error{ErrorCode::unsupported, option + ": \"" + text + "\": this build evaluates no expressions",
               "build ticktrue with muParser: apt-get install libmuparser-dev"};
}
void Expression::begin(const engine::Engine&) {}
double Expression::evaluate(const engine::Engine&) {
  return 0;
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

}  // namespace ticktrue::verifier
