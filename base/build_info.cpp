// Build facts, most of them defined by CMake.
// SPDX-License-Identifier: MIT
#include "base/build_info.h"

#include "base/bytes.h"

namespace ticktrue {
namespace {

std::string compiler_name() {
#if defined(__clang__)
  return "clang " + std::to_string(__clang_major__) + "." + std::to_string(__clang_minor__) + "." +
         std::to_string(__clang_patchlevel__);
#elif defined(__GNUC__)
  return "gcc " + std::to_string(__GNUC__) + "." + std::to_string(__GNUC_MINOR__) + "." +
         std::to_string(__GNUC_PATCHLEVEL__);
#else
  return "unknown";
#endif
}

std::string target_name() {
#if defined(__x86_64__)
  std::string name = "x86_64";
#elif defined(__i386__)
  std::string name = "i386";
#elif defined(__aarch64__)
  std::string name = "aarch64";
#elif defined(__arm__)
  std::string name = "arm";
#elif defined(__riscv)
  std::string name = "riscv";
#elif defined(__s390x__)
  std::string name = "s390x";
#elif defined(__powerpc64__)
  std::string name = "ppc64";
#elif defined(__wasm__)
  std::string name = "wasm";
#else
  std::string name = "unknown";
#endif
#if defined(_WIN32)
  name += " windows";
#endif
  return name + (machine_is_little_endian ? " little-endian " : " big-endian ") + std::to_string(sizeof(void*) * 8) +
         "-bit";
}

}  // namespace

const BuildInfo& build_info() {
  static const BuildInfo info{
      TICKTRUE_VERSION,
      TICKTRUE_COMMIT,
      compiler_name(),
      TICKTRUE_FLAGS,
      target_name(),
#ifdef TICKTRUE_HAS_ZSTD
      true,
#else
      false,
#endif
#ifdef TICKTRUE_HAS_BOX2D
      true,
#else
      false,
#endif
#ifdef TICKTRUE_HAS_THREADS
      true,
#else
      false,
#endif
  };
  return info;
}

std::string build_line() {
  const BuildInfo& info = build_info();
  return "ticktrue " + info.version + " (" + info.commit + ") " + info.compiler + " " + info.flags + " " + info.target;
}

}  // namespace ticktrue
