/// Where a mesh touches or passes through itself and the surface that it stands for does not.
#pragma once

#include "gradus/mesh/self_contact.hpp"
#include "gradus/mesh/soup.hpp"
#include "gradus/quality/mesh_edges.hpp"

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace gradus {

struct NewContact {
    SelfContacts::Pair triangles;  ///< of the mesh
    Eigen::Vector3d point;         ///< between them
};

struct NewContacts {
    std::size_t count = 0;           ///< of those found; at least that many where the search was given up
    std::vector<NewContact> listed;  ///< in the order of their triangles, no more than kListed
    static constexpr std::size_t kListed = 2000;
};

/// Asks meshes of one surface for their contacts. Those of the surface itself are looked for once, when a mesh has any.
class ContactFinder {
  public:
    /// It must outlive this.
    explicit ContactFinder(const TriangleSoup& surface) : surface_(&surface) {}

    /// Contacts of a mesh (see find_self_contacts) from which no contact of the surface is within the longest edge of
    /// the two triangles.
    NewContacts of(const MeshView& mesh);

  private:
    bool has_contact_near(const Eigen::Vector3d& p, double reach) const;

    const TriangleSoup* surface_;
    std::optional<SelfContacts> known_;  // of the surface
};

}  // namespace gradus
