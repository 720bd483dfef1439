/// Makes an oriented manifold of a soup, as far as that takes no guessing, and says what it did.
///
/// In this order:
///  1. Triangles with a vertex that is none, or with a coordinate that is not finite, are dropped.
///  2. Vertices at the same place are taken for one, with a tolerance those close to each other: in the order of
///     their indices, each joins the closest of those before it that stay, if that is within the tolerance, and stays
///     itself otherwise. So a vertex moves by the tolerance at most, onto one that did not move: dense regions thin
///     out but do not run together.
///  3. Triangles that have a vertex twice, then, are dropped: their other two sides have become one. So are copies of
///     a triangle, in any orientation.
///  4. Where an open edge runs along another one, within the tolerance, the other one is split at its vertex
///     (T-junctions).
///  5. Flat triangles (Diagnosis::zero_area) are resolved, longest first, and tight where it was tight: the middle
///     corner splits the triangles across the long side, so that these meet the short sides directly, and the flat
///     triangle is dropped. One with a side as short as the rounding of its ends loses that side instead. If this
///     comes to no end, all are left as they are.
///  6. Sides of two triangles at one edge are joined, and the pieces oriented alike: the smaller part of each is
///     turned, and what is closed then has its outside outside. Pieces that agree in themselves stay as they are,
///     cavities among them. Where a piece has one side only (Moebius strip), it is cut along the edges that cannot
///     agree.
///  7. Edges of three triangles and more come apart into sheets. What the input joins in pairs stays joined. Where
///     solids touch (the triangles around the edge face each other in turn), each keeps its own; else the two that
///     continue each other straightest are joined, again and again, until those are oriented differently; the others
///     are cut off.
///  8. Surfaces that touch in a vertex only come apart.
///  9. Vertices in no triangle are dropped.
/// So vertices at one place, joined in 2, stay or become several where sheets or fans of triangles pass each other.
///
/// What remains keeps its order, points their bits where nothing was welded; vertices added by cuts come last. Labels,
/// feature edges, corners, required elements and parameters follow; of a required triangle that was split none is
/// required.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gradus/mesh/diagnose.hpp"

namespace gradus {

struct RepairOptions {
    /// Distance within which vertices are one, as a fraction of the diagonal of the bounding box of the triangles, in
    /// [0, 0.1].
    double weld_tolerance = 0;
    /// Only vertices at open edges, those of one triangle, are welded within the tolerance: what is closed stays apart
    /// from the rest.
    bool only_open = false;
    /// Triangles whose height is no more than this part of their longest side, and that bend away from the one across
    /// it by more than 10 degrees, are resolved as flat ones are: they hold gaps as wide as that. At least 0.
    double flatness = 0;
};

/// A distance far below the edges, within which vertices at open edges are the same: a thousandth of the edges there
/// (of all but the shortest 5 %), and a few roundings of the coordinates at least. As a fraction of the diagonal; 0
/// where no edge is open.
double tolerance_of(const TriangleSoup& soup);

/// What mends cracks and T-junctions, and moves nothing else: vertices at open edges, within tolerance_of(), and
/// slivers of 1e-4.
RepairOptions default_repair(const TriangleSoup& soup);

/// What default_repair() joins at open edges.
struct Cracks {
    int twins = 0;      ///< vertices that are taken for another one
    int junctions = 0;  ///< edges split at a vertex

    bool empty() const { return twins == 0 && junctions == 0; }
};
Cracks find_cracks(const TriangleSoup& soup);

/// Takes vertices at open edges that are a few roundings of the coordinates apart for one, the first. For soups that
/// were read triangle by triangle; only points, triangles and their labels are kept. @returns number of vertices that
/// are gone
int weld_roundings(TriangleSoup& soup);

enum class RepairKind {
    OutOfRange,           ///< triangle
    BadNumbers,           ///< triangle
    WeldedVertices,       ///< vertex, vertex that joined it
    RepeatedIndex,        ///< triangle
    SplitEdges,           ///< vertex, ends of the edge
    FlatTriangles,        ///< triangle, then the triangles split for it
    DuplicateTriangles,   ///< triangle, its copy
    TurnedTriangles,      ///< triangle
    OneSidedEdges,        ///< vertex, vertex: cut, as no orientation agrees across it
    NonManifoldEdges,     ///< vertex, vertex: come apart into sheets
    NonManifoldVertices,  ///< vertex: come apart, and on none of these edges
    UnusedVertices,       ///< vertex
    LostFeatures          ///< vertices of a feature or required edge, corner, required vertex or triangle, or entry of
                          ///< parameters that has no place in the result
};

/// What was done of one kind. An item is a few indices of the input.
struct RepairStep {
    RepairKind kind;
    Findings<std::vector<int>> items;
};

struct Repaired {
    TriangleSoup soup;                 ///< is_manifold()
    std::vector<RepairStep> steps;     ///< in the order of RepairKind; none: the soup is the input, bit by bit
    std::vector<int> point_source;     ///< point of the input, per point: the one that stayed of those that were welded
    std::vector<int> triangle_source;  ///< triangle of the input, per triangle: which it is, or is a piece of
};

/// A sound soup (is_clean_manifold) comes back as it is unless a tolerance welds; so does every result.
/// O(n log n), by sorting and a grid.
/// @throws std::invalid_argument for a tolerance outside [0, 0.1], or labels that are not one per triangle
Repaired repair(const TriangleSoup& soup, const RepairOptions& options = {});

/// Fields of the input on the result.
/// @param source  point_source or triangle_source  @throws std::invalid_argument for a field that has no values for one
/// of them
std::vector<Field> follow(std::span<const Field> fields, std::span<const int> source);

/// "welded_vertices"
std::string_view name_of(RepairKind kind);

/// A line for each step, with its count and the first few cases. Empty if there are none.
std::string summary(const std::vector<RepairStep>& steps);

}  // namespace gradus
