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

constexpr std::uint32_t common_degrees = 3;  // of bodies that move as one

/// Counts the freedom that is left around a joint: the pebble game. Each body has three degrees of freedom, its
/// pebbles. Each row of an eliminated joint takes one of a body that it acts on. All that is not eliminated counts as
/// one body, the ground. A row is independent of the others if four free pebbles can be gathered on its bodies. To
/// gather one, rows along a path are taken over by the next body of the path.
class Freedom {
 public:
  Freedom(std::uint32_t body_count, const std::vector<GraphJoint>& joints, const std::vector<std::uint8_t>& turns)
      : joints_(joints),
        ground_(body_count),
        is_eliminated_(body_count, false),
        free_(body_count + 1, common_degrees),
        owned_(body_count + 1),
        came_from_(body_count + 1) {
    for (std::uint32_t body = 0; body < body_count; ++body)
      if (!turns.empty() && turns[body] == 0) --free_[body];
  }

  /// Whether the rows are independent of those of eliminated joints.
  bool is_enough_for(std::uint32_t joint) { return gather(joint, common_degrees + joints_[joint].row_count); }

  /// The joint's rows take their pebbles; those that depend on other rows take none.
  void eliminate_joint(std::uint32_t joint) {
    for (std::uint32_t row = 0; row < joints_[joint].row_count; ++row) {
      if (!gather(joint, common_degrees + 1)) return;
      for (const std::uint32_t body : bodies_of(joint))
        if (free_[body] > 0) {
          take(body, joint);
          break;
        }
    }
  }

  /// The body leaves the ground. It takes over the rows that act on the ground no more.
  void eliminate_body(std::uint32_t body) {
    is_eliminated_[body] = true;
    std::vector<std::uint32_t> rows;
    rows.swap(owned_[ground_]);
    free_[ground_] = common_degrees;
    for (const std::uint32_t joint : rows) {
      const Bodies bodies = bodies_of(joint);
      if (std::find(bodies.begin(), bodies.end(), ground_) != bodies.end())
        take(ground_, joint);
      else if (free_[body] > 0)
        take(body, joint);
    }
  }

 private:
  using Bodies = std::vector<std::uint32_t>;

  /// Bodies that are not eliminated, and those that no joint moves, are the ground.
  Bodies bodies_of(std::uint32_t joint) const {
    const GraphJoint& row = joints_[joint];
    Bodies bodies;
    bool is_grounded = row.is_to_world;
    for (std::uint32_t i = 0; i < row.body_count; ++i) {
      if (is_eliminated_[row.bodies[i]])
        bodies.push_back(row.bodies[i]);
      else
        is_grounded = true;
    }
    if (is_grounded) bodies.push_back(ground_);
    return bodies;
  }

  void take(std::uint32_t body, std::uint32_t joint) {
    --free_[body];
    owned_[body].push_back(joint);
  }

  /// Gathers so many free pebbles on the bodies of a joint, if there are so many.
  bool gather(std::uint32_t joint, std::uint32_t wanted) {
    const Bodies bodies = bodies_of(joint);
    std::uint32_t count = 0;
    for (const std::uint32_t body : bodies) count += free_[body];
    while (count < wanted && fetch_one(bodies)) ++count;
    return count >= wanted;
  }

  /// Frees a pebble of one of the bodies by one that lies elsewhere. False: none can be reached.
  bool fetch_one(const Bodies& bodies) {
    std::fill(came_from_.begin(), came_from_.end(), Step{});
    std::vector<std::uint32_t> queue;
    for (const std::uint32_t body : bodies) {
      came_from_[body].is_seen = true;
      queue.push_back(body);
    }
    for (std::size_t at = 0; at < queue.size(); ++at) {
      const std::uint32_t body = queue[at];
      for (const std::uint32_t joint : owned_[body])
        for (const std::uint32_t other : bodies_of(joint)) {
          if (came_from_[other].is_seen) continue;
          came_from_[other] = {true, body, joint};
          if (free_[other] > 0) {
            hand_over(other);
            return true;
          }
          queue.push_back(other);
        }
    }
    return false;
  }

  /// Each body on the path to `last` takes over the row that led there.
  void hand_over(std::uint32_t last) {
    while (came_from_[last].joint != no_node) {
      const Step step = came_from_[last];
      std::vector<std::uint32_t>& rows = owned_[step.body];
      rows.erase(std::find(rows.begin(), rows.end(), step.joint));
      ++free_[step.body];
      take(last, step.joint);
      last = step.body;
    }
  }

  struct Step {
    bool is_seen = false;
    std::uint32_t body = 0;
    std::uint32_t joint = no_node;  // no_node: the path begins here
  };

  const std::vector<GraphJoint>& joints_;
  std::uint32_t ground_;
  std::vector<bool> is_eliminated_;                // [body]
  std::vector<std::uint32_t> free_;                // [body or ground] pebbles
  std::vector<std::vector<std::uint32_t>> owned_;  // [body or ground] joints, once for each row
  std::vector<Step> came_from_;                    // [body or ground] of the search
};

/// Bodies are the nodes 0 .. body_count - 1, joints the nodes from body_count on.
class Elimination {
 public:
  Elimination(std::uint32_t body_count, const std::vector<GraphJoint>& joints, const std::vector<std::uint8_t>& turns)
      : body_count_(body_count),
        joints_(joints),
        freedom_(body_count, joints, turns),
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
    for (std::uint32_t i = 0; i < row.body_count; ++i)
      if (row.is_last && !is_done_[row.bodies[i]]) return false;
    return freedom_.is_enough_for(joint);
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
      freedom_.eliminate_joint(node - body_count_);
    else
      freedom_.eliminate_body(node);
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
  Freedom freedom_;
  std::vector<std::vector<std::uint32_t>> neighbours_;            // [node] not eliminated, ascending
  std::vector<bool> is_done_;                                     // [node]
  std::set<std::pair<std::uint32_t, std::uint32_t>> candidates_;  // degree, node; joints with an eliminated neighbour
  std::vector<std::uint32_t> order_;
  JointGraph graph_;
};

}  // namespace

std::uint32_t count_loops(std::uint32_t body_count, const std::vector<GraphJoint>& joints) {
  std::vector<std::uint32_t> parents(body_count);
  for (std::uint32_t body = 0; body < body_count; ++body) parents[body] = body;
  std::uint32_t loop_count = 0;
  for (const GraphJoint& joint : joints)
    for (std::uint32_t i = 1; i < joint.body_count; ++i) {
      if (find_root(parents, joint.bodies[0]) == find_root(parents, joint.bodies[i])) ++loop_count;
      unite(parents, joint.bodies[0], joint.bodies[i]);
    }
  return loop_count;
}

JointGraph make_joint_graph(std::uint32_t body_count, const std::vector<GraphJoint>& joints,
                            const std::vector<std::uint8_t>& turns) {
  return Elimination(body_count, joints, turns).run();
}

}  // namespace ticktrue::engine
