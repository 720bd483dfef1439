/// Where a surface touches or passes through itself.
#pragma once

#include <array>

#include "gradus/mesh/diagnose.hpp"

namespace gradus {

struct SelfContacts {
    using Pair = std::array<int, 2>;  ///< triangles, the smaller first
    Findings<Pair> pairs;
    bool complete = true;  ///< false: so much lies upon itself that the search was given up; there are more
};

/// Pairs of triangles with more in common than the vertices and edges they share: without a common vertex they touch or
/// intersect, with one they meet in another point too, with a common edge they fold onto each other in a plane, or they
/// are copies. Decided exactly for the coordinates as they are (lengths below 1e-90 of the largest coordinate aside).
/// Vertices at the same place are the same. Triangles that are faulty, or exactly on a line, are passed over, see
/// Diagnosis. O(n log n) where boxes of few triangles meet; the same for any number of threads.
/// @param most  pairs that are listed
SelfContacts find_self_contacts(const TriangleSoup& soup, std::size_t most = Findings<SelfContacts::Pair>::kListed);

}  // namespace gradus
