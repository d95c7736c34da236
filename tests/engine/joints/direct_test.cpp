// The factorisation of the direct joint solver: order, fill, and solutions against a dense solve with pivoting.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/random.h"
#include "engine/joints/direct/block_ldl.h"
#include "engine/joints/direct/joint_graph.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;

namespace {

// ---- Graphs ----

GraphJoint joint_between(std::uint32_t a, std::uint32_t b, std::uint32_t rows = 2) {
  return {{a, b}, 2, rows};
}
GraphJoint joint_to_world(std::uint32_t body, std::uint32_t rows = 2) {
  return {{body}, 1, rows, true};
}

std::vector<GraphJoint> chain_of(std::uint32_t count) {
  std::vector<GraphJoint> joints = {joint_to_world(0)};
  for (std::uint32_t body = 1; body < count; ++body) joints.push_back(joint_between(body - 1, body));
  return joints;
}

std::vector<GraphJoint> hub_with(std::uint32_t rods) {
  std::vector<GraphJoint> joints;
  for (std::uint32_t rod = 1; rod <= rods; ++rod) joints.push_back(joint_between(0, rod));
  return joints;
}

std::vector<GraphJoint> net_of(std::uint32_t side, std::uint32_t rows) {
  std::vector<GraphJoint> joints;
  for (std::uint32_t body = 0; body < side * side; ++body) {
    if (body % side > 0) joints.push_back(joint_between(body - 1, body, rows));
    if (body >= side) joints.push_back(joint_between(body - side, body, rows));
  }
  return joints;
}

std::vector<GraphJoint> random_tree(Random& random, std::uint32_t count) {
  std::vector<GraphJoint> joints;
  for (std::uint32_t body = 1; body < count; ++body) {
    const auto parent = static_cast<std::uint32_t>(random.below(body));
    joints.push_back(joint_between(parent, body, static_cast<std::uint32_t>(1 + random.below(3))));
  }
  return joints;
}

// ---- Systems ----

struct LinearProblem {
  std::vector<double> masses;
  std::vector<double> inertias;
  std::vector<GraphJoint> joints;
  std::vector<std::array<Block, joint_body_max>> gradients;  // [joint][place]
  double compliance = 1e-10;                                 // of rows that blocks eliminate, and of articulated angles
  std::vector<bool> has_free_angle;                          // [joint] its third row is not in the system; empty: none
};

// Constraint rows of revolute and weld joints with random lever arms. Masses are from 1 to `ratio`.
LinearProblem problem_of(Random& random, std::uint32_t body_count, std::vector<GraphJoint> joints, double ratio) {
  LinearProblem problem;
  for (std::uint32_t body = 0; body < body_count; ++body) {
    problem.masses.push_back(std::exp(random.real(0, std::log(ratio))));
    problem.inertias.push_back(problem.masses.back() * random.real(0.1, 1));
  }
  for (const GraphJoint& joint : joints) {
    std::array<Block, joint_body_max> gradients{};
    for (std::uint32_t i = 0; i < joint.body_count; ++i) {
      const double sign = i == 0 ? -1 : 1;
      const double x = random.real(-1, 1);
      const double y = random.real(-1, 1);
      gradients[i] = {sign, 0, -sign * y, 0, sign, sign * x, 0, 0, sign};
      for (std::size_t row = joint.row_count; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) gradients[i][3 * row + column] = 0;
    }
    problem.gradients.push_back(gradients);
  }
  problem.joints = std::move(joints);
  return problem;
}

bool is_free_angle(const LinearProblem& problem, std::size_t joint, std::size_t row) {
  return row == 2 && !problem.has_free_angle.empty() && problem.has_free_angle[joint];
}

Triple compliances_of(const LinearProblem& problem, const JointGraph& graph, std::size_t joint) {
  const bool is_articulated = graph.nodes[graph.joint_nodes[joint]].articulation != no_articulation;
  Triple r{1, 1, 1};
  for (std::uint32_t row = 0; row < problem.joints[joint].row_count; ++row)
    if (!is_free_angle(problem, joint, row)) r[row] = is_articulated && row < 2 ? 0 : problem.compliance;
  return r;
}

// As direct_island.cpp sets articulations.
void set_articulation(const LinearProblem& problem, const JointGraph& graph, BlockSystem& system, std::size_t joint) {
  const std::uint32_t number = graph.nodes[graph.joint_nodes[joint]].articulation;
  const std::uint32_t child = graph.nodes[graph.articulations[number].child].index;
  const GraphJoint& ends = problem.joints[joint];
  ArticulatedArms arms;
  for (std::uint32_t i = 0; i < ends.body_count; ++i) {
    const Block& gradient = problem.gradients[joint][i];
    const double sign = gradient[0];
    const bool is_child = ends.bodies[i] == child;
    (is_child ? arms.child_x : arms.parent_x) = sign * gradient[5];
    (is_child ? arms.child_y : arms.parent_y) = -sign * gradient[2];
    if (is_child) arms.sign = sign;
  }
  arms.has_angle = ends.row_count == 3 && !is_free_angle(problem, joint, 2);
  arms.angle_compliance = problem.compliance;
  system.articulated[number].arms = arms;
}

void fill(const LinearProblem& problem, const JointGraph& graph, BlockSystem& system) {
  clear_system(graph, system);
  for (std::uint32_t body = 0; body < problem.masses.size(); ++body)
    set_body(graph, system, body, problem.masses[body], problem.inertias[body]);
  for (std::uint32_t joint = 0; joint < problem.joints.size(); ++joint) {
    if (graph.nodes[graph.joint_nodes[joint]].articulation != no_articulation) {
      set_articulation(problem, graph, system, joint);
      continue;
    }
    set_joint(graph, system, joint, compliances_of(problem, graph, joint));
    for (std::uint32_t i = 0; i < problem.joints[joint].body_count; ++i)
      set_gradient(graph, system, joint, i, problem.gradients[joint][i]);
  }
}

// The dense matrix [M, G^T; G, -c], bodies first.
std::vector<std::vector<double>> dense_of(const LinearProblem& problem, const JointGraph& graph) {
  const std::size_t bodies = problem.masses.size();
  const std::size_t size = 3 * (bodies + problem.joints.size());
  std::vector<std::vector<double>> a(size, std::vector<double>(size, 0));
  for (std::size_t body = 0; body < bodies; ++body) {
    a[3 * body][3 * body] = a[3 * body + 1][3 * body + 1] = problem.masses[body];
    a[3 * body + 2][3 * body + 2] = problem.inertias[body];
  }
  for (std::size_t joint = 0; joint < problem.joints.size(); ++joint) {
    const std::size_t first = 3 * (bodies + joint);
    const Triple compliances = compliances_of(problem, graph, joint);
    for (std::size_t row = 0; row < 3; ++row) a[first + row][first + row] = -compliances[row];
    for (std::uint32_t i = 0; i < problem.joints[joint].body_count; ++i)
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) {
          const double value = problem.gradients[joint][i][3 * row + column];
          a[first + row][3 * problem.joints[joint].bodies[i] + column] = value;
          a[3 * problem.joints[joint].bodies[i] + column][first + row] = value;
        }
  }
  return a;
}

// Gaussian elimination with pivoting.
std::vector<double> dense_solution(std::vector<std::vector<double>> a, std::vector<double> b) {
  const std::size_t size = b.size();
  for (std::size_t at = 0; at < size; ++at) {
    std::size_t best = at;
    for (std::size_t row = at + 1; row < size; ++row)
      if (std::fabs(a[row][at]) > std::fabs(a[best][at])) best = row;
    std::swap(a[at], a[best]);
    std::swap(b[at], b[best]);
    for (std::size_t row = at + 1; row < size; ++row) {
      const double factor = a[row][at] / a[at][at];
      if (factor == 0) continue;
      for (std::size_t column = at; column < size; ++column) a[row][column] -= factor * a[at][column];
      b[row] -= factor * b[at];
    }
  }
  for (std::size_t at = size; at-- > 0;) {
    for (std::size_t column = at + 1; column < size; ++column) b[at] -= a[at][column] * b[column];
    b[at] /= a[at][at];
  }
  return b;
}

struct Errors {
  double velocity = 0;  // error against the dense solution, relative to the largest velocity
  double row = 0;       // error of G v - c p = r, relative to the largest r
};

Errors errors_of(const LinearProblem& problem, Random& random) {
  const std::size_t bodies = problem.masses.size();
  const JointGraph graph = make_joint_graph(static_cast<std::uint32_t>(bodies), problem.joints);
  BlockSystem system;
  fill(problem, graph, system);
  std::vector<double> b(3 * (bodies + problem.joints.size()), 0);
  for (std::size_t joint = 0; joint < problem.joints.size(); ++joint)
    for (std::uint32_t row = 0; row < problem.joints[joint].row_count; ++row)
      if (!is_free_angle(problem, joint, row)) b[3 * (bodies + joint) + row] = random.real(-1, 1);
  const auto node_of = [&](std::size_t block) {
    return block < bodies ? graph.body_nodes[block] : graph.joint_nodes[block - bodies];
  };
  for (std::size_t i = 0; i < b.size(); ++i) system.values[node_of(i / 3)][i % 3] = b[i];
  for (std::size_t at = 0; at < graph.nodes.size(); ++at) factor_node(graph, system, at);
  solve(graph, system);
  const std::vector<std::vector<double>> a = dense_of(problem, graph);
  const std::vector<double> x = dense_solution(a, b);
  Errors errors;
  double largest = 0;
  for (std::size_t i = 0; i < 3 * bodies; ++i) {
    largest = std::max(largest, std::fabs(x[i]));
    errors.velocity = std::max(errors.velocity, std::fabs(system.values[node_of(i / 3)][i % 3] - x[i]));
  }
  errors.velocity /= largest;
  for (std::size_t i = 3 * bodies; i < b.size(); ++i) {
    double sum = -b[i];
    for (std::size_t k = 0; k < b.size(); ++k) sum += a[i][k] * system.values[node_of(k / 3)][k % 3];
    errors.row = std::max(errors.row, std::fabs(sum));
  }
  return errors;
}

std::size_t redundant_count(const JointGraph& graph) {
  return static_cast<std::size_t>(
      std::count_if(graph.nodes.begin(), graph.nodes.end(), [](const GraphNode& node) { return node.is_redundant; }));
}

std::vector<std::uint32_t> indices_of(const JointGraph& graph, bool joints) {
  std::vector<std::uint32_t> indices;
  for (const GraphNode& node : graph.nodes)
    if (node.is_joint == joints) indices.push_back(node.index);
  return indices;
}

}  // namespace

TEST_CASE("trees are eliminated from their leaves without fill", "[engine][joints][direct]") {
  const JointGraph chain = make_joint_graph(5, chain_of(5));
  REQUIRE(chain.fill_blocks.empty());
  REQUIRE(indices_of(chain, false) == std::vector<std::uint32_t>{4, 3, 2, 1, 0});
  REQUIRE(indices_of(chain, true) == std::vector<std::uint32_t>{4, 3, 2, 1, 0});
  const JointGraph hub = make_joint_graph(101, hub_with(100));
  REQUIRE(hub.fill_blocks.empty());
  REQUIRE(hub.nodes.size() == 201);
  REQUIRE(hub.body_nodes[0] >= 198);
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const auto count = static_cast<std::uint32_t>(2 + random.below(80));
    const JointGraph tree = make_joint_graph(count, random_tree(random, count));
    REQUIRE(tree.fill_blocks.empty());
    REQUIRE(redundant_count(tree) == 0);
    REQUIRE(tree.block_rows.size() == 2 * (count - 1));
    for (const GraphNode& node : tree.nodes) REQUIRE(node.block_count <= 1);
  }
}

TEST_CASE("loops are counted, and each adds little", "[engine][joints][direct]") {
  REQUIRE(count_loops(5, chain_of(5)) == 0);
  REQUIRE(count_loops(9, net_of(3, 2)) == 4);
  std::vector<GraphJoint> two_pegs = chain_of(20);
  two_pegs.push_back(joint_to_world(19));
  REQUIRE(count_loops(20, two_pegs) == 0);
  REQUIRE(make_joint_graph(20, two_pegs).fill_blocks.size() <= 2);
  std::vector<GraphJoint> ring = chain_of(30);
  ring.push_back(joint_between(0, 29));
  REQUIRE(count_loops(30, ring) == 1);
  const JointGraph graph = make_joint_graph(30, ring);
  REQUIRE(redundant_count(graph) == 0);
  for (const GraphNode& node : graph.nodes) REQUIRE(node.block_count <= 2);
}

TEST_CASE("joints beyond the degrees of freedom are told", "[engine][joints][direct]") {
  REQUIRE(redundant_count(make_joint_graph(9, net_of(3, 2))) == 0);
  REQUIRE(redundant_count(make_joint_graph(9, net_of(3, 3))) == 4);
  REQUIRE(redundant_count(make_joint_graph(2, {joint_between(0, 1, 3), joint_between(0, 1, 3)})) == 1);
}

TEST_CASE("block elimination agrees with a dense solve", "[engine][joints][direct]") {
  Random random(2);
  for (const double ratio : {1.0, 100.0, 1e6})
    for (int i = 0; i < 20; ++i) {
      const auto count = static_cast<std::uint32_t>(2 + random.below(40));
      INFO("ratio " << ratio << ", " << count << " bodies");
      const Errors errors = errors_of(problem_of(random, count, random_tree(random, count), ratio), random);
      REQUIRE(errors.velocity < 1e-9);
      REQUIRE(errors.row < 1e-9);
    }
  for (const std::uint32_t side : {2u, 3u}) {
    const Errors errors = errors_of(problem_of(random, side * side, net_of(side, 2), 10), random);
    INFO(side);
    REQUIRE(errors.velocity < 1e-8);
    REQUIRE(errors.row < 1e-8);
  }
  std::vector<GraphJoint> ring = chain_of(30);
  ring.push_back(joint_between(0, 29));
  ring.push_back(joint_to_world(15));
  const Errors errors = errors_of(problem_of(random, 30, ring, 10), random);
  REQUIRE(errors.velocity < 1e-8);
  REQUIRE(errors.row < 1e-8);
}

TEST_CASE("loops from which bodies hang agree with a dense solve", "[engine][joints][direct]") {
  // A body that hangs on a loop has freedom of its own. Counted for the loop, it made a pivot of rounding errors: the
  // errors were about 1.
  Random random(5);
  int judged = 0;
  for (int i = 0; i < 300; ++i) {
    const auto count = static_cast<std::uint32_t>(4 + random.below(12));
    std::vector<GraphJoint> joints;
    for (std::uint32_t body = 1; body < count; ++body)
      joints.push_back(joint_between(static_cast<std::uint32_t>(random.below(body)), body, 2));
    for (std::uint64_t extra = 1 + random.below(3); extra > 0; --extra) {
      const auto a = static_cast<std::uint32_t>(random.below(count - 1));
      const auto b = static_cast<std::uint32_t>(a + 1 + random.below(count - 1 - a));
      joints.push_back(joint_between(a, b, static_cast<std::uint32_t>(1 + random.below(2))));
    }
    if (random.below(2) == 0) joints.push_back(joint_to_world(static_cast<std::uint32_t>(random.below(count))));
    if (redundant_count(make_joint_graph(count, joints)) > 0) continue;
    ++judged;
    CAPTURE(i, count, joints.size());
    const Errors errors = errors_of(problem_of(random, count, joints, 10), random);
    CHECK(errors.velocity < 1e-6);
    CHECK(errors.row < 1e-6);
  }
  CHECK(judged > 200);
}

// Makes the joints of two and three rows joints of a point, and frees the angles of some.
void hold_points(Random& random, LinearProblem& problem) {
  for (std::size_t joint = 0; joint < problem.joints.size(); ++joint) {
    problem.joints[joint].holds_point = problem.joints[joint].row_count > 1;
    const bool is_free = problem.joints[joint].row_count == 3 && random.below(2) == 0;
    problem.has_free_angle.push_back(is_free);
    if (!is_free) continue;
    for (Block& gradient : problem.gradients[joint]) gradient[6] = gradient[7] = gradient[8] = 0;
  }
}

TEST_CASE("articulated bodies agree with a dense solve", "[engine][joints][direct]") {
  Random random(4);
  std::size_t articulation_count = 0;
  for (const double ratio : {1.0, 100.0, 1e6})
    for (const double compliance : {0.0, 1e-3, 1.0, 1e3})
      for (int i = 0; i < 20; ++i) {
        const auto count = static_cast<std::uint32_t>(2 + random.below(40));
        std::vector<GraphJoint> joints = random_tree(random, count);
        for (GraphJoint& joint : joints)
          if (compliance == 0 && joint.row_count == 1) joint.row_count = 2;  // blocks need a compliance
        if (random.below(2) == 0) joints.push_back(joint_to_world(static_cast<std::uint32_t>(random.below(count))));
        LinearProblem problem = problem_of(random, count, joints, ratio);
        problem.compliance = compliance;
        hold_points(random, problem);
        INFO("ratio " << ratio << ", " << count << " bodies, compliance " << compliance);
        const JointGraph graph = make_joint_graph(count, problem.joints);
        articulation_count += graph.articulations.size();
        const Errors errors = errors_of(problem, random);
        REQUIRE(errors.velocity < 1e-9);
        REQUIRE(errors.row < 1e-9);
      }
  REQUIRE(articulation_count > 2000);
  // Trees that hang on a loop.
  for (int i = 0; i < 20; ++i) {
    std::vector<GraphJoint> joints = random_tree(random, 30);
    for (GraphJoint& joint : joints) joint.row_count = 2;
    joints.push_back(joint_between(3, 17));
    joints.push_back(joint_to_world(5));
    LinearProblem problem = problem_of(random, 30, joints, 10);
    hold_points(random, problem);
    const JointGraph graph = make_joint_graph(30, problem.joints);
    INFO(i);
    REQUIRE(!graph.articulations.empty());
    REQUIRE(graph.articulations.size() < joints.size());
    const Errors errors = errors_of(problem, random);
    // Where the tree joins the two bodies of the loop already, their rows contradict each other, and the compliance of
    // 1e-10 alone bounds the impulses: rounding grows by up to 1e10.
    REQUIRE(errors.velocity < 1e-7);
    REQUIRE(errors.row < 1e-7);
  }
}

TEST_CASE("each body of a chain or hub of points is articulated but the root", "[engine][joints][direct]") {
  for (std::vector<GraphJoint> joints : {chain_of(20), hub_with(19)}) {
    for (GraphJoint& joint : joints) joint.holds_point = true;
    const JointGraph graph = make_joint_graph(20, joints);
    REQUIRE(graph.articulations.size() + 1 >= joints.size());  // the last joint of a hub follows both its bodies
    for (const Articulation& articulation : graph.articulations) {
      REQUIRE(!graph.nodes[articulation.child].is_joint);
      REQUIRE(graph.nodes[articulation.child].is_carried);
    }
  }
  // Two bodies that two joints connect: neither joint alone holds one.
  std::vector<GraphJoint> pair = {joint_between(0, 1), joint_between(0, 1), joint_to_world(0)};
  for (GraphJoint& joint : pair) joint.holds_point = true;
  REQUIRE(make_joint_graph(2, pair).articulations.size() <= 1);
}

TEST_CASE("a joint of four bodies fits the elimination", "[engine][joints][direct]") {
  Random random(3);
  const std::vector<GraphJoint> gear = {joint_between(0, 1), joint_between(2, 3), {{0, 1, 2, 3}, 4, 1}};
  REQUIRE(count_loops(4, gear) == 2);
  REQUIRE(redundant_count(make_joint_graph(4, gear)) == 0);
  const Errors errors = errors_of(problem_of(random, 4, gear, 10), random);
  REQUIRE(errors.velocity < 1e-9);
  REQUIRE(errors.row < 1e-9);
}
