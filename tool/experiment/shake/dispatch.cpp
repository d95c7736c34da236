// Libraries that choose their kernels by the processor.
// SPDX-License-Identifier: MIT
// Source: documents of OpenBLAS (OPENBLAS_CORETYPE), oneMKL (MKL_CBWR), PyTorch (ATEN_CPU_CAPABILITY) and numpy
// (NPY_DISABLE_CPU_FEATURES).
#include "tool/experiment/shake/dispatch.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <string_view>

#include "base/plain_text.h"
#include "shim/page.h"
#include "tool/experiment/ddmin.h"
#include "tool/experiment/shake/facts.h"

namespace ticktrue::shake {
namespace {

/// A processor generation that a library can be told to assume.
struct Level {
  std::string_view value;
  std::string_view missing;  // features that this level lacks and the newer level has
};

struct Library {
  std::string_view variable;
  std::string_view module;        // part of the file name of the library
  std::span<const Level> levels;  // newest first; empty: the variable lists features to disable
};

constexpr Level openblas_levels[] = {
    {"Haswell", "avx512f"}, {"Sandybridge", "fma avx2"}, {"Nehalem", "avx"}, {"Prescott", "sse4_2"}};
constexpr Level mkl_levels[] = {{"AVX2", "avx512f"}, {"AVX", "fma avx2"}, {"COMPATIBLE", "avx sse4_2"}};
constexpr Level torch_levels[] = {{"avx2", "avx512f"}, {"default", "fma avx2"}};
constexpr std::string_view numpy_variable = "NPY_DISABLE_CPU_FEATURES";
constexpr Library libraries[] = {{"OPENBLAS_CORETYPE", "openblas", openblas_levels},
                                 {"MKL_CBWR", "libmkl_", mkl_levels},
                                 {"ATEN_CPU_CAPABILITY", "libtorch_cpu", torch_levels},
                                 {numpy_variable, "_multiarray_umath", {}}};

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

const Library* find_library(const std::string& variable) {
  const auto found = std::find_if(std::begin(libraries), std::end(libraries),
                                  [&](const Library& library) { return library.variable == variable; });
  return found == std::end(libraries) ? nullptr : found;
}

/// The first file loaded by a run whose name contains `part`.
std::string loaded_module(Launcher& launcher, const Conditions& guilty, std::string_view part) {
  constexpr std::size_t line_count_max = 20'000;
  const std::string path = launcher.options().folder + "/mapped";
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  Conditions told = guilty;
  told.environment.emplace_back(shim::mapped_variable, path);
  if (!launcher.run(told)) return "";
  std::ifstream file(path);
  std::string line;
  for (std::size_t count = 0; count < line_count_max && std::getline(file, line); ++count)
    if (std::filesystem::path(line).filename().string().find(part) != std::string::npos) return plain_line(line);
  return "";
}

}  // namespace

void choose_oldest_kernels(Conditions& conditions) {
  for (const Library& library : libraries)
    if (!library.levels.empty()) conditions.environment.emplace_back(library.variable, library.levels.back().value);
}

void leave_out_features(Conditions& conditions) {
  // numpy prints a warning for features that the processor lacks, so only present features are listed.
  const char* features = processor_has("avx512f") ? "FMA3 AVX2 AVX512F AVX512CD AVX512_SKX" : "FMA3 AVX2";
  conditions.environment.emplace_back(numpy_variable, features);
}

DispatchCause narrow_dispatch(Launcher& launcher, const Conditions& guilty,
                              const std::function<bool(const Conditions&)>& is_other) {
  const auto with = [&](const std::string& variable, const std::string& value) {
    Conditions conditions = guilty;
    conditions.environment = {{variable, value}};
    return conditions;
  };
  for (const auto& setting : guilty.environment) {
    const std::string& variable = setting.first;
    const std::optional<std::string>& value = setting.second;
    const Library* library = find_library(variable);
    if (library == nullptr || !value || !is_other(with(variable, *value))) continue;
    DispatchCause cause;
    cause.variable = variable;
    for (const Level& level : library->levels)
      if (is_other(with(variable, std::string(level.value)))) {
        cause.features = words_of(std::string(level.missing));
        break;
      }
    if (library->levels.empty()) {
      const std::vector<std::string> words = words_of(*value);
      const auto chosen = [&](const std::vector<std::size_t>& indices) {
        std::vector<std::string> some;
        for (const std::size_t index : indices) some.push_back(words[index]);
        return some;
      };
      cause.features = chosen(soak::ddmin(words.size(), [&](const std::vector<std::size_t>& indices) {
        return !indices.empty() && is_other(with(variable, joined(chosen(indices))));
      }));
    }
    cause.module = loaded_module(launcher, guilty, library->module);
    return cause;
  }
  return {};
}

}  // namespace ticktrue::shake
