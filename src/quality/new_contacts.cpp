#include "gradus/quality/new_contacts.hpp"

#include "gradus/mesh/closest.hpp"

#include <algorithm>

namespace gradus {

using Eigen::Vector3d;

NewContacts ContactFinder::of(const MeshView& mesh) {
    const TriangleSoup soup{.points = {mesh.points.begin(), mesh.points.end()},
                            .triangles = {mesh.triangles.begin(), mesh.triangles.end()}};
    NewContacts found;
    const SelfContacts contacts = find_self_contacts(soup, NewContacts::kListed);
    if (contacts.pairs.empty()) return found;
    if (!known_) known_ = find_self_contacts(*surface_, NewContacts::kListed);
    found.count = contacts.pairs.count;
    for (const SelfContacts::Pair& pair : contacts.pairs.first) {
        Vector3d middle = Vector3d::Zero();
        double longest = 0;
        for (const int t : pair)
            for (int k = 0; k < 3; ++k) {
                const Vector3d &p = soup.points[soup.triangles[t][k]], &q = soup.points[soup.triangles[t][(k + 1) % 3]];
                middle += p / 6;
                longest = std::max(longest, (q - p).norm());
            }
        if (has_contact_near(middle, longest))
            --found.count;
        else
            found.listed.push_back({pair, middle});
    }
    return found;
}

bool ContactFinder::has_contact_near(const Vector3d& p, double reach) const {
    return std::any_of(known_->pairs.first.begin(), known_->pairs.first.end(), [&](const SelfContacts::Pair& pair) {
        return std::all_of(pair.begin(), pair.end(), [&](int t) {
            const auto [a, b, c] = surface_->triangles[t];
            return (closest_point(p, surface_->points[a], surface_->points[b], surface_->points[c]) - p).norm() < reach;
        });
    });
}

}  // namespace gradus
