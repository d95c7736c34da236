// The order in which the direct joint solver eliminates bodies and joints: least degree, ties by index.
// SPDX-License-Identifier: MIT
// Source: as joint_graph.h.
#include "engine/joints/direct/joint_graph.h"

#include <algorithm>
#include <set>
#include <utility>

#include "base/assert.h"
#include "engine/math/union_find.h"

namespace ticktrue::engine {
namespace {

constexpr std::int64_t common_degrees = 3;  // of bodies that move as one

/// The freedom that is left to a set of bodies that eliminated joints connect.
struct Freedom {
  std::int64_t degrees = 3;
  std::uint32_t ties = 0;  // eliminated joints to the world or to bodies that are not eliminated
};

/// Sets of bodies that eliminated joints connect.
class Components {
 public:
  Components(std::uint32_t body_count, const std::vector<std::uint8_t>& turns)
      : parent_(body_count), freedom_(body_count) {
    for (std::uint32_t body = 0; body < body_count; ++body) {
      parent_[body] = body;
      if (!turns.empty() && turns[body] == 0) --freedom_[body].degrees;
    }
  }

  std::uint32_t find(std::uint32_t body) { return find_root(parent_, body); }
  /// False: both were in one set.
  bool unite(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a == b) return false;
    if (b < a) std::swap(a, b);
    parent_[b] = a;
    freedom_[a].degrees += freedom_[b].degrees;
    freedom_[a].ties += freedom_[b].ties;
    return true;
  }
  Freedom& freedom(std::uint32_t body) { return freedom_[find(body)]; }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<Freedom> freedom_;  // [root]
};

/// Bodies are the nodes 0 .. body_count - 1, joints the nodes from body_count on.
class Elimination {
 public:
  Elimination(std::uint32_t body_count, const std::vector<GraphJoint>& joints, const std::vector<std::uint8_t>& turns)
      : body_count_(body_count),
        joints_(joints),
        components_(body_count, turns),
        tied_(body_count),
        neighbours_(body_count + joints.size()),
        is_done_(body_count + joints.size(), false) {
    for (std::uint32_t joint = 0; joint < joints.size(); ++joint)
      for (std::uint32_t i = 0; i < joints[joint].body_count; ++i) {
        TICKTRUE_ASSERT(joints[joint].bodies[i] < body_count);
        connect(joints[joint].bodies[i], body_count + joint);
      }
    for (std::uint32_t body = 0; body < body_count; ++body) candidates_.insert({degree(body), body});
  }

  JointGraph run() {
    std::vector<std::vector<std::uint32_t>> patterns;
    for (std::size_t left = neighbours_.size(); left > 0; --left) {
      const auto [node, is_redundant] = choose();
      order_.push_back(node);
      const std::uint32_t index = is_joint(node) ? node - body_count_ : node;
      graph_.nodes.push_back({is_joint(node), is_redundant, index, is_joint(node) ? joints_[index].dimension : 3});
      patterns.push_back(neighbours_[node]);
      eliminate(node);
    }
    list_blocks(patterns);
    list_targets();
    place_gradients();
    list_articulations();
    list_fill();
    return std::move(graph_);
  }

 private:
  bool is_joint(std::uint32_t node) const { return node >= body_count_; }
  std::uint32_t degree(std::uint32_t node) const { return static_cast<std::uint32_t>(neighbours_[node].size()); }

  void connect_to(std::uint32_t from, std::uint32_t to) {
    std::vector<std::uint32_t>& list = neighbours_[from];
    const auto place = std::lower_bound(list.begin(), list.end(), to);
    if (place == list.end() || *place != to) list.insert(place, to);
  }
  void connect(std::uint32_t a, std::uint32_t b) {
    connect_to(a, b);
    connect_to(b, a);
  }

  bool is_ready(std::uint32_t joint) {
    const GraphJoint& row = joints_[joint];
    std::int64_t degrees = 0;
    bool is_held = row.is_to_world;
    for (std::uint32_t i = 0; i < row.body_count; ++i) {
      if (!is_done_[row.bodies[i]]) {
        if (row.is_last) return false;
        is_held = true;
        continue;
      }
      const std::uint32_t root = components_.find(row.bodies[i]);
      is_held = is_held || components_.freedom(root).ties > 0;
      bool is_counted = false;
      for (std::uint32_t k = 0; k < i; ++k)
        is_counted = is_counted || (is_done_[row.bodies[k]] && components_.find(row.bodies[k]) == root);
      if (!is_counted) degrees += components_.freedom(root).degrees;
    }
    return degrees >= row.row_count + (is_held ? 0 : common_degrees);
  }

  /// The next node, and whether the node is a joint that never became ready.
  std::pair<std::uint32_t, bool> choose() {
    for (const auto& [node_degree, node] : candidates_)
      if (!is_joint(node) || is_ready(node - body_count_)) return {node, false};
    std::uint32_t joint = body_count_;
    while (is_done_[joint]) ++joint;
    return {joint, true};
  }

  void eliminate(std::uint32_t node) {
    candidates_.erase({degree(node), node});
    is_done_[node] = true;
    if (is_joint(node))
      tie(node - body_count_);
    else
      for (const std::uint32_t other : tied_[node]) {
        --components_.freedom(other).ties;
        components_.unite(node, other);
      }
    const std::vector<std::uint32_t> around = neighbours_[node];
    for (const std::uint32_t neighbour : around) {
      candidates_.erase({degree(neighbour), neighbour});
      std::vector<std::uint32_t>& list = neighbours_[neighbour];
      list.erase(std::lower_bound(list.begin(), list.end(), node));
    }
    for (std::size_t i = 0; i < around.size(); ++i)
      for (std::size_t k = i + 1; k < around.size(); ++k) connect(around[i], around[k]);
    for (const std::uint32_t neighbour : around) candidates_.insert({degree(neighbour), neighbour});
  }

  /// Unites the sets of a joint's eliminated bodies. Later it unites the sets of its other bodies, once they are
  /// eliminated.
  void tie(std::uint32_t joint) {
    const GraphJoint& row = joints_[joint];
    std::uint32_t first = no_node;
    for (std::uint32_t i = 0; i < row.body_count; ++i) {
      const std::uint32_t body = row.bodies[i];
      if (!is_done_[body]) continue;
      if (first == no_node) first = body;
      components_.unite(first, body);
    }
    if (first == no_node) return;
    Freedom& freedom = components_.freedom(first);
    freedom.degrees -= row.row_count;
    freedom.ties += row.is_to_world ? 1u : 0u;
    for (std::uint32_t i = 0; i < row.body_count; ++i) {
      if (is_done_[row.bodies[i]]) continue;
      tied_[row.bodies[i]].push_back(first);
      ++freedom.ties;
    }
  }

  void list_blocks(const std::vector<std::vector<std::uint32_t>>& patterns) {
    std::vector<std::uint32_t> place(neighbours_.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) place[order_[i]] = i;
    graph_.body_nodes.assign(place.begin(), place.begin() + body_count_);
    graph_.joint_nodes.assign(place.begin() + body_count_, place.end());
    for (std::size_t i = 0; i < order_.size(); ++i) {
      std::set<std::uint32_t> rows;
      for (const std::uint32_t node : patterns[i]) rows.insert(place[node]);
      graph_.nodes[i].first_block = static_cast<std::uint32_t>(graph_.block_rows.size());
      graph_.nodes[i].block_count = static_cast<std::uint32_t>(rows.size());
      graph_.block_rows.insert(graph_.block_rows.end(), rows.begin(), rows.end());
    }
  }

  /// The block of these rows and columns, both given as nodes. Requires: the nodes are coupled, column < row.
  std::uint32_t block_of(std::uint32_t row, std::uint32_t column) const {
    const GraphNode& node = graph_.nodes[column];
    const auto begin = graph_.block_rows.begin() + node.first_block;
    const auto found = std::lower_bound(begin, begin + node.block_count, row);
    TICKTRUE_ASSERT(found != begin + node.block_count && *found == row);
    return static_cast<std::uint32_t>(found - graph_.block_rows.begin());
  }

  void list_targets() {
    for (GraphNode& node : graph_.nodes) {
      node.first_target = static_cast<std::uint32_t>(graph_.targets.size());
      const std::uint32_t end = node.first_block + node.block_count;
      for (std::uint32_t i = node.first_block; i < end; ++i)
        for (std::uint32_t k = i + 1; k < end; ++k)
          graph_.targets.push_back(block_of(graph_.block_rows[k], graph_.block_rows[i]));
    }
  }

  void place_gradients() {
    graph_.gradients.resize(joints_.size());
    for (std::size_t joint = 0; joint < joints_.size(); ++joint)
      for (std::uint32_t i = 0; i < joints_[joint].body_count; ++i) {
        const std::uint32_t body_node = graph_.body_nodes[joints_[joint].bodies[i]];
        const std::uint32_t joint_node = graph_.joint_nodes[joint];
        const bool is_transposed = joint_node < body_node;
        const std::uint32_t block = is_transposed ? block_of(body_node, joint_node) : block_of(joint_node, body_node);
        graph_.gradients[joint][i] = {block, is_transposed};
      }
  }

  /// Finds the joints of a point whose one body is eliminated before them and is coupled to nothing else, while nothing
  /// else that is eliminated before them is coupled to them.
  void list_articulations() {
    std::vector<std::uint32_t> coupled_before(graph_.nodes.size());
    for (const std::uint32_t row : graph_.block_rows) ++coupled_before[row];
    for (std::uint32_t at = 0; at < graph_.nodes.size(); ++at) {
      GraphNode& body = graph_.nodes[at];
      if (body.is_joint || body.block_count != 1) continue;
      const std::uint32_t row = graph_.block_rows[body.first_block];
      GraphNode& node = graph_.nodes[row];
      if (!node.is_joint || coupled_before[row] != 1) continue;
      const GraphJoint& joint = joints_[node.index];
      if (!joint.holds_point || node.block_count + 1 != joint.body_count) continue;
      Articulation articulation{at, no_node};
      if (joint.body_count == 2) articulation.parent = graph_.block_rows[node.first_block];
      body.is_carried = true;
      node.articulation = static_cast<std::uint32_t>(graph_.articulations.size());
      graph_.articulations.push_back(articulation);
    }
  }

  /// Requires: place_gradients.
  void list_fill() {
    std::vector<bool> is_set(graph_.block_rows.size());
    for (std::size_t joint = 0; joint < joints_.size(); ++joint)
      for (std::uint32_t i = 0; i < joints_[joint].body_count; ++i) is_set[graph_.gradients[joint][i].block] = true;
    for (std::uint32_t block = 0; block < is_set.size(); ++block)
      if (!is_set[block]) graph_.fill_blocks.push_back(block);
    for (const GraphNode& node : graph_.nodes) graph_.column_max = std::max(graph_.column_max, node.block_count);
  }

  std::uint32_t body_count_;
  const std::vector<GraphJoint>& joints_;
  Components components_;
  std::vector<std::vector<std::uint32_t>> tied_;                  // [body] eliminated bodies behind eliminated joints
  std::vector<std::vector<std::uint32_t>> neighbours_;            // [node] not eliminated, ascending
  std::vector<bool> is_done_;                                     // [node]
  std::set<std::pair<std::uint32_t, std::uint32_t>> candidates_;  // degree, node; joints with an eliminated neighbour
  std::vector<std::uint32_t> order_;
  JointGraph graph_;
};

}  // namespace

std::uint32_t count_loops(std::uint32_t body_count, const std::vector<GraphJoint>& joints) {
  Components components(body_count, {});
  std::uint32_t loop_count = 0;
  for (const GraphJoint& joint : joints)
    for (std::uint32_t i = 1; i < joint.body_count; ++i)
      loop_count += components.unite(joint.bodies[0], joint.bodies[i]) ? 0u : 1u;
  return loop_count;
}

JointGraph make_joint_graph(std::uint32_t body_count, const std::vector<GraphJoint>& joints,
                            const std::vector<std::uint8_t>& turns) {
  return Elimination(body_count, joints, turns).run();
}

}  // namespace ticktrue::engine
