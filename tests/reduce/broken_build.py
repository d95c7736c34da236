# Builds a copy of the tree whose engine makes the mistake that the variable TICKTRUE_PLANTED selects.
# SPDX-License-Identifier: MIT
#
#   broken_build.py TREE FOLDER [JOBS]
#
# TREE is the tree to copy, FOLDER the new folder of the copy. The program is FOLDER/build/release/ticktrue.
# TICKTRUE_PLANTED=7: the change of arithmetic with this number, as another compiler, library or processor would make
# it.
# TICKTRUE_PLANTED=flip STAGE TABLE COLUMN LANE BIT WHERE WHERE_LANE LOWER UPPER: after this stage, a bit of the column
# flips. It flips in the first row of the table in which lane WHERE_LANE of column WHERE is in LOWER..UPPER.
# Without the variable, the copy computes like the tree.
import os
import subprocess
import sys

NUMBER = """// Which planted mistake is made.
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdlib>

namespace ticktrue {

inline int planted_number() {
  static const int number = [] {
    const char* text = std::getenv("TICKTRUE_PLANTED");
    return text == nullptr ? 0 : std::atoi(text);
  }();
  return number;
}

}  // namespace ticktrue
"""

FLIP = """// A bit that flips after a stage.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string>

#include "base/state/state_view.h"

namespace ticktrue {

struct PlantedFlip {
  std::string word, stage, table, column, where;
  unsigned lane = 0, bit = 0, where_lane = 0;
  double lower = 0, upper = 0;
};

inline const PlantedFlip& planted_flip() {
  static const PlantedFlip flip = [] {
    PlantedFlip read;
    const char* text = std::getenv("TICKTRUE_PLANTED");
    std::istringstream words(text == nullptr ? "" : text);
    words >> read.word >> read.stage >> read.table >> read.column >> read.lane >> read.bit >> read.where >>
        read.where_lane >> read.lower >> read.upper;
    return read;
  }();
  return flip;
}

inline const Column* planted_column(const TableSchema& table, const std::string& name) {
  for (const Column& column : table.columns)
    if (column.name == name) return &column;
  return nullptr;
}

inline double planted_value(const std::uint8_t* at, ScalarType type) {
  float single = 0;
  double whole = 0;
  std::uint32_t count = 0;
  if (type == ScalarType::f32) return std::memcpy(&single, at, 4), double{single};
  if (type == ScalarType::f64) return std::memcpy(&whole, at, 8), whole;
  return std::memcpy(&count, at, 4), static_cast<double>(count);
}

inline void plant_after_stage(const std::string& stage, const StateView& view) {
  const PlantedFlip& flip = planted_flip();
  if (flip.word != "flip" || flip.stage != stage) return;
  const auto table = view.schema->find_table(flip.table);
  if (!table) return;
  const TableSchema& schema = view.schema->tables[*table];
  const Column* column = planted_column(schema, flip.column);
  const Column* where = planted_column(schema, flip.where);
  if (column == nullptr || where == nullptr) return;
  const unsigned where_size = where->type == ScalarType::f64 ? 8 : 4, size = column->type == ScalarType::f64 ? 8 : 4;
  for (std::size_t row = 0; row < view.tables[*table].row_count; ++row) {
    std::uint8_t* begin = const_cast<std::uint8_t*>(view.tables[*table].data) + row * schema.row_size;
    const double value = planted_value(begin + where->offset + flip.where_lane * where_size, where->type);
    if (!(value >= flip.lower && value <= flip.upper)) continue;
    begin[column->offset + flip.lane * size + flip.bit / 8] ^= static_cast<std::uint8_t>(1u << flip.bit % 8);
    return;
  }
}

}  // namespace ticktrue
"""

VEC2, CIRCLES, KERNELS = "engine/math/vec2.h", "engine/narrow_phase/collide_circles.cpp", "engine/contacts/contact_kernels.cpp"
MOTION, FORCES = "engine/integrators/motion_kernels.cpp", "engine/integrators/forces.cpp"
# number: file, text, and the text to insert before it while the number is planted
CHANGES = {
    1: (VEC2, "  return {q.c * v.x - q.s * v.y, q.s * v.x + q.c * v.y};",
     "return {std::fma(q.c, v.x, -(q.s * v.y)), std::fma(q.s, v.x, q.c * v.y)};"),
    2: (VEC2, "  return {q.c * v.x + q.s * v.y, q.c * v.y - q.s * v.x};",
     "return {std::fma(q.c, v.x, q.s * v.y), std::fma(q.c, v.y, -(q.s * v.x))};"),
    3: (VEC2, "  return a.x * b.x + a.y * b.y;", "return std::fma(a.x, b.x, a.y * b.y);"),
    4: (VEC2, "  return a.x * b.y - a.y * b.x;", "return std::fma(a.x, b.y, -(a.y * b.x));"),
    5: (VEC2, "  return a.x * a.x + a.y * a.y;", "return std::fma(a.x, a.x, a.y * a.y);"),
    6: (VEC2, "  return {a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};",
     "return {std::fma(a.c, b.c, -(a.s * b.s)), std::fma(a.s, b.c, a.c * b.s)};"),
    7: (VEC2, "  return {a.c * b.c + a.s * b.s, a.c * b.s - a.s * b.c};",
     "return {std::fma(a.c, b.c, a.s * b.s), std::fma(a.c, b.s, -(a.s * b.c))};"),
    8: (VEC2, "  const Real scale = Real(1) / square_root(q.c * q.c + q.s * q.s);",
     "{ const Real size = square_root(q.c * q.c + q.s * q.s); return {q.c / size, q.s / size}; }"),
    10: (MOTION, "    velocity = decay * velocity + gain;",
     "{ velocity = (decay * velocity + gain * Real(0.25)) + gain * Real(0.75); "
     "std::memcpy(bodies + begin, &velocity, sizeof velocity); continue; }"),
    11: (MOTION, "    const RealxN c = delta.c * pose.at[2] - delta.s * pose.at[3];",
     "pose.at[0] = (pose.at[0] - step * velocity.at[0]) + velocity.at[0] / broadcast(Real(1) / h);"),
    12: (MOTION, "  // quadrant modulo 4, in -2..2.",
     "{ const_cast<RealxN&>(sine) = x * (broadcast(1) + z * series(sine_terms, term_count)); }"),
    13: (KERNELS, "      const V wanted = old_impulse - lanes.load(point.tangent_mass) * velocity;",
     "{ const_cast<V&>(velocity) = (tangent_velocity + wb * arm_b) - wa * arm_a; }"),
    14: (KERNELS, "    wa -= (pair.inv_inertia_a * arm_a) * change;\n    wb += (pair.inv_inertia_b * arm_b) * change;\n"
     "    normal_sum += change;",
     "{ wa -= pair.inv_inertia_a * (arm_a * change); wb += pair.inv_inertia_b * (arm_b * change); "
     "normal_sum += change; continue; }"),
    15: (CIRCLES, "  const Vec2 on_a = center_a + radius_a * manifold.normal;",
     "{ if (distance > 0) manifold.normal = {offset.x / distance, offset.y / distance}; }"),
    16: (CIRCLES, "  if (!(separation <= margin)) return manifold;",
     "{ const_cast<Real&>(separation) = distance - (radius_a + radius_b); }"),
    19: ("engine/contacts/soft.h", "  return {omega / a1, a2 * a3, a3};", "return {omega / a1, 1 - a3, a3};"),
    20: (FORCES, "  line.tension = spring.stiffness * (line.length - spring.rest_length);",
     "{ line.tension = spring.stiffness * line.length - spring.stiffness * spring.rest_length; return line; }"),
    21: (FORCES, "    if (linear_loss != 0) body.velocity",
     "{ if (linear_loss != 0) { body.velocity = solved.model.wind + Vec2{through_air.x / (1 + linear_loss), "
     "through_air.y / (1 + linear_loss)}; continue; } }"),
    22: ("engine/joints/joint_distance.cpp", "  return longer + dot(span.row.axis, arm_rotation_rate(span.arm_a, span.arm_b, pair, h));",
     "return (whole - 2 * span.distance > 0 ? (whole - 2 * span.distance) / h : Real(0)) + "
     "dot(span.row.axis, arm_rotation_rate(span.arm_a, span.arm_b, pair, h));"),
}


def change(folder, name, text, to):
    path = os.path.join(folder, name)
    with open(path) as file:
        source = file.read()
    if text not in source:
        sys.exit(f"broken_build: error: {name}: found no \"{text}\", which is what would be broken")
    with open(path, "w") as file:
        file.write(source.replace(text, to, 1))


def write(folder, name, text):
    with open(os.path.join(folder, name), "w") as file:
        file.write(text)


def main(tree, folder, jobs="2"):
    os.makedirs(folder)
    archive = subprocess.run(["git", "-C", tree, "archive", "HEAD"], check=True, stdout=subprocess.PIPE).stdout
    subprocess.run(["tar", "-x", "-C", folder], input=archive, check=True)
    write(folder, "engine/math/planted_number.h", NUMBER)
    write(folder, "engine/planted_flip.h", FLIP)
    for number, (name, text, instead) in CHANGES.items():
        change(folder, name, text, f"  if (planted_number() == {number}) {instead}\n{text}")
    for name in {name for name, _, _ in CHANGES.values()}:
        change(folder, name, "#pragma once\n" if name.endswith(".h") else "#include",
               '#pragma once\n\n#include "engine/math/planted_number.h"\n' if name.endswith(".h")
               else '#include "engine/math/planted_number.h"\n#include')
    world = "engine/world.cpp"
    run = "      pipeline_.stages[i].stage->run(model_, state_, tick_, dt);\n"
    change(folder, world, run, run + "      update_view(state_, pipeline_.tables, view_);\n"
           "      plant_after_stage(stage_names_[i], view_);\n")
    change(folder, world, "#include", '#include "engine/planted_flip.h"\n#include')
    environment = dict(os.environ, CMAKE_CXX_COMPILER_LAUNCHER="ccache", CCACHE_BASEDIR=folder)
    subprocess.run(["cmake", "--preset", "release"], cwd=folder, env=environment, check=True)
    subprocess.run(["nice", "-n", "5", "cmake", "--build", "build/release", "-j", jobs, "--target", "ticktrue"],
                   cwd=folder, env=environment, check=True)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("usage: broken_build.py TREE FOLDER [JOBS]")
    main(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), *sys.argv[3:4])
