/// Features of a triangle mesh: what a mesh of the same surface must keep.
#pragma once

#include "gradus/mesh/connectivity.hpp"
#include "gradus/mesh/flats.hpp"

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

namespace gradus {

struct FeatureOptions {
    double angle =
        0.698;  ///< dihedral angle (between normals) from which an edge is a crease, radians in (0, pi]: 40 degrees
    /// All edges from `angle` on are features, whatever is beside them: who asks for an angle means it.
    bool all_from_angle = false;
    double ridge_angle = 0.035;  ///< from which a bend of planes, that no round explains, is a crease: 2 degrees
    /// Below this an edge is none where the surface turns on as fast on both sides of it, as a coarse mesh of a round
    /// does: 55 degrees, so that six sides make a prism and seven a cylinder.
    double sharp_angle = 0.96;
    double weak_angle = 0.436;  ///< from which it continues one: 25 degrees
    /// Creases that end freely and have fewer edges than this are noise, and left out.
    int shortest = 5;
    /// Creases that hang together without closing a loop are noise too where they are shorter than this in all, over
    /// the diagonal.
    double shortest_tree = 0.05;
    /// Creases that rise less than about a seventh of this length, over this length to both sides, are none, and jags
    /// of feature curves that rise more than this length over the line between their neighbours are corners. Of two
    /// creases less than about a seventh of it apart, with facets between that are three times as long as they are
    /// wide, one counts. 0: all creases count, and no jags.
    double scale = 0;
    /// Turns between strips of planes, or of their outlines, are ridges, or corners, where a round through them would
    /// rise more than this over its facets: to follow it would take elements far smaller than these. Unit of length.
    double largest_sag = std::numeric_limits<double>::infinity();
    /// Edges, by their ends, that are no creases by their angles alone, and vertices that are no corners by turns of a
    /// curve.
    std::vector<std::array<int, 2>> no_creases = {};
    std::vector<int> no_corners = {};
    double corner_angle = 0.785;  ///< turn of a feature curve from which its vertex is a corner, radians: 45 degrees
    /// Within reach of these places edges that turn by more than 60 degrees are creases, however rough the surface is.
    std::vector<Eigen::Vector3d> places = {};
    double reach = 0;
};

/// A feature curve between two corners, or a closed one without.
struct FeatureChain {
    std::vector<int> vertices;  ///< in order; those of a closed chain once each
    bool closed = false;
    bool certain = true;  ///< false: all that speaks for it are angles between facets; it is not given, no border, and
                          ///< no planes meet there

    int label = 0;  ///< of the soup's edges that it is, if they have labels

    int num_edges() const { return static_cast<int>(vertices.size()) - (closed ? 0 : 1); }
    int vertex(int i) const { return vertices[i % vertices.size()]; }
};

struct Features {
    std::vector<FeatureChain> chains;
    std::vector<char> corner;  ///< per vertex: where chains end, meet or turn, and the points of cones

    /// Of all chains, by their ends.
    std::vector<std::array<int, 2>> edges() const {
        std::vector<std::array<int, 2>> all;
        for (const FeatureChain& chain : chains)
            for (int i = 0; i < chain.num_edges(); ++i) all.push_back({chain.vertex(i), chain.vertex(i + 1)});
        return all;
    }
};

/// What is known of the features beforehand. All may be empty.
struct KnownFeatures {
    std::span<const std::array<int, 2>> edges{};  ///< those that are no side of a triangle are passed over
    std::span<const int> corners{};
    std::span<const int> labels{};  ///< one per triangle: edges between different labels are features
};

/// Whether edge i of a chain is longer than those it meets, by more than chords of a round are: a straight part of an
/// outline.
bool is_straight_chord(std::span<const Eigen::Vector3d> points, const FeatureChain& chain, int i);

/// Boundaries, creases with hysteresis (an edge above the weak angle is one where it continues a crease), borders of
/// labels and what is given. Half-edges of `mesh` are tagged with the number of their chain, others with -1. A vertex
/// of two feature edges is a corner where the curve turns by the corner angle both from edge to edge and over three
/// edges on either side: a jagged curve has none, but where its jags are high.
/// @param regions  of this mesh, if they are known
Features find_features(std::span<const Eigen::Vector3d> points, Connectivity& mesh, const FeatureOptions& options = {},
                       const KnownFeatures& known = {}, const PlanarRegions* regions = nullptr);

/// A vertex as one side of the features sees it: its corners between two tagged edges, or all where it has none.
struct Wedges {
    std::vector<int> of_corner;  ///< wedge of each half-edge's origin, in its triangle
    std::vector<int> vertex;     ///< of each wedge; the first wedge of vertex v has the number v
    std::vector<int>
        first;  ///< half-edge of each wedge from which rotating, up to a tagged one or around, passes its triangles

    int size() const { return static_cast<int>(vertex.size()); }
    /// Calls use(h) for the half-edges of a wedge, one per triangle.
    template <class Use>
    void for_each(const Connectivity& mesh, int wedge, const Use& use) const {
        const int begin = first[wedge];
        int h = begin;
        while (h != Connectivity::kNone) {
            use(h);
            h = mesh.tag(Connectivity::prev(h)) >= 0 ? Connectivity::kNone : mesh.rotate(h);
            if (h == begin) break;
        }
    }
};

Wedges wedges_of(const Connectivity& mesh);

}  // namespace gradus
