// CPU, instruction set and control word, for people only (base/float_behaviour.h makes decisions).
// SPDX-License-Identifier: MIT
#include "verifier/report/machine.h"

#include <cstdint>
#include <cstdio>

#include "base/compiler/compiler.h"

namespace ticktrue::verifier {
namespace {

/// Only Linux has this file.
std::string cpu_name() {
  std::FILE* file = std::fopen("/proc/cpuinfo", "rb");
  if (file == nullptr) return "";
  std::string name;
  char line[512];
  while (name.empty() && std::fgets(line, sizeof line, file) != nullptr) {
    const std::string text = line;
    const std::size_t colon = text.find(": ");
    const bool is_name =
        text.compare(0, 10, "model name") == 0 || text.compare(0, 4, "cpu\t") == 0 || text.compare(0, 4, "uarch") == 0;
    if (is_name && colon != std::string::npos) name = text.substr(colon + 2, text.find_last_not_of("\r\n") - colon - 1);
  }
  std::fclose(file);
  return name;
}

std::string instruction_set() {
#if defined(__AVX512F__)
  return "AVX-512";
#elif defined(__AVX2__)
  return "AVX2";
#elif defined(__AVX__)
  return "AVX";
#elif defined(__SSE2__)
  return "SSE2";
#elif defined(__ARM_NEON)
  return "NEON";
#elif defined(__VSX__)
  return "VSX";
#elif defined(__ALTIVEC__)
  return "AltiVec";
#elif defined(__wasm_simd128__)
  return "SIMD128";
#elif defined(__VX__)
  return "vector facility";
#else
  return "scalar";
#endif
}

std::string control_word() {
  const compiler::FloatControl control = compiler::float_control();
  if (control.name == nullptr) return "";
  char text[48];
  std::snprintf(text, sizeof text, "%s %08llx", control.name, static_cast<unsigned long long>(control.word));
  return text;
}

}  // namespace

MachineFacts machine_facts() {
  return {cpu_name(), instruction_set(), control_word()};
}

}  // namespace ticktrue::verifier
