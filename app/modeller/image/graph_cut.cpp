#include "app/modeller/image/graph_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

// Boost's headers do not compile without warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/property_map/property_map.hpp>
#pragma GCC diagnostic pop

namespace stylet::modeller {

namespace {

using Node = std::uint32_t;
using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, Node, Node>;
using GraphEdge = boost::graph_traits<Graph>::edge_descriptor;

constexpr Node kNone = std::numeric_limits<Node>::max();
constexpr float kUnits = 1000.0f;  // capacity for a cost of one
constexpr float kMaxCost = 1e5f;   // maximum cost, so that sums of six fit into int

int edgeCapacity(float cost) {
    return int(std::lround(kUnits * std::clamp(cost, 0.0f, kMaxCost / kUnits)));
}

// Steps to the neighbours. Step k and step 5 - k are opposite.
constexpr std::array<Index3, 6> kCutSteps{Index3(0, 0, -1), Index3(0, -1, 0), Index3(-1, 0, 0),
                                          Index3(1, 0, 0),  Index3(0, 1, 0),  Index3(0, 0, 1)};

// The free voxels as nodes 0 ... count - 1, then source and sink. Edges of a node: to its free neighbours
// in step order, then to the one terminal that it prefers.
class BandGraph {
  public:
    explicit BandGraph(const CutProblem& problem) : problem_(problem), grid_(problem.state.grid) {
        number();
        sizeEdges();
        link();
    }

    Mask cut() {
        const Node source = count_, sink = count_ + 1;
        const std::size_t nodes = std::size_t(count_) + 2;
        const Graph graph(boost::edges_are_sorted, edges_.begin(), edges_.end(), Node(nodes),
                          Node(edges_.size()));
        edges_ = {};
        std::vector<int> residual(capacity_.size());
        std::vector<GraphEdge> predecessor(nodes);
        std::vector<boost::default_color_type> colour(nodes);
        std::vector<int> distance(nodes);
        const auto edge_index = get(boost::edge_index, graph);
        const auto node_index = get(boost::vertex_index, graph);
        boost::boykov_kolmogorov_max_flow(
            graph, boost::make_iterator_property_map(capacity_.begin(), edge_index),
            boost::make_iterator_property_map(residual.begin(), edge_index),
            boost::make_iterator_property_map(reverse_.begin(), edge_index),
            boost::make_iterator_property_map(predecessor.begin(), node_index),
            boost::make_iterator_property_map(colour.begin(), node_index),
            boost::make_iterator_property_map(distance.begin(), node_index), node_index, source, sink);
        return maskWhere(grid_, [&](std::size_t i) {
            return node_of_[i] != kNone ? colour[node_of_[i]] == boost::black_color
                                        : stateAt(i) == CutState::object;
        });
    }

  private:
    CutState stateAt(std::size_t i) const { return CutState(problem_.state.voxels[i]); }

    void number() {
        node_of_.assign(grid_.voxelCount(), kNone);
        for (std::size_t i = 0; i < node_of_.size(); ++i)
            if (stateAt(i) == CutState::free) {
                node_of_[i] = count_++;
                voxels_.push_back(i);
            }
    }

    // Calls f(step number, neighbour's offset) for each neighbour in the grid.
    template <typename F>
    void forEachNeighbour(std::size_t i, const F& f) const {
        const Index3 at = grid_.voxelAt(i);
        for (std::size_t k = 0; k < kCutSteps.size(); ++k)
            if (const Index3 to = at + kCutSteps[k]; grid_.contains(to)) f(k, grid_.offset(to));
    }

    // Computes the index of each node's first edge. Adds the links to fixed neighbours to the node's
    // preference.
    void sizeEdges() {
        first_.assign(std::size_t(count_) + 1, 0);
        terminal_.assign(count_, 0);
        Node toward_source = 0, toward_sink = 0;
        for (Node n = 0; n < count_; ++n) {
            const std::size_t i = voxels_[n];
            float preference = problem_.preference.voxels[i];
            Node free = 0;
            forEachNeighbour(i, [&](std::size_t, std::size_t j) {
                if (stateAt(j) == CutState::free)
                    ++free;
                else
                    preference += stateAt(j) == CutState::object ? problem_.link(i, j) : -problem_.link(i, j);
            });
            terminal_[n] = preference < 0.0f ? -edgeCapacity(-preference) : edgeCapacity(preference);
            ++(terminal_[n] < 0 ? toward_sink : toward_source);
            first_[n + 1] = first_[n] + free + 1;
        }
        const std::size_t edges = 2 * std::size_t(count_) + first_[count_] - count_;
        edges_.resize(edges);
        capacity_.assign(edges, 0);
        reverse_.resize(edges);
        source_next_ = first_[count_];
        sink_next_ = source_next_ + toward_source;
    }

    void link() {
        for (Node n = 0; n < count_; ++n) {
            Node e = first_[n];
            forEachNeighbour(voxels_[n], [&](std::size_t k, std::size_t j) {
                if (node_of_[j] == kNone) return;
                const int capacity = edgeCapacity(problem_.link(voxels_[n], j));
                set(e++, n, node_of_[j], capacity, reverseEdge(j, k));
            });
            const bool from_source = terminal_[n] >= 0;
            const Node terminal = from_source ? count_ : count_ + 1;
            const Node at_terminal = from_source ? source_next_++ : sink_next_++;
            set(e, n, terminal, from_source ? 0 : -terminal_[n], at_terminal);
            set(at_terminal, terminal, n, from_source ? terminal_[n] : 0, e);
        }
    }

    void set(Node e, Node from, Node to, int capacity, Node back) {
        edges_[e] = {from, to};
        capacity_[e] = capacity;
        reverse_[e] = GraphEdge(to, back);
    }

    // The edge of voxel j's node in the direction opposite to step k.
    Node reverseEdge(std::size_t j, std::size_t k) const {
        Node e = first_[node_of_[j]];
        forEachNeighbour(j, [&](std::size_t m, std::size_t i) {
            e += m < kCutSteps.size() - 1 - k && node_of_[i] != kNone;
        });
        return e;
    }

    const CutProblem& problem_;
    const Grid& grid_;
    Node count_ = 0;
    std::vector<Node> node_of_, first_;
    std::vector<std::pair<Node, Node>> edges_;
    std::vector<std::size_t> voxels_;
    std::vector<int> terminal_, capacity_;  // terminal: positive from the source, negative to the sink
    std::vector<GraphEdge> reverse_;
    Node source_next_ = 0, sink_next_ = 0;
};

}  // namespace

Mask minimumCut(const CutProblem& problem) {
    return BandGraph(problem).cut();
}

}  // namespace stylet::modeller
