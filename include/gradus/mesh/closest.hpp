/// Closest triangles.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "gradus/mesh/tri_mesh.hpp"

namespace gradus {

/// The closest point of the triangle abc to p, also for a triangle without area.
Eigen::Vector3d closest_point(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::Vector3d& c);

/// A tree of boxes over triangles. The spans must outlive it.
class ClosestTriangle {
  public:
    /// @param chosen  triangles to look among, by index; not empty
    ClosestTriangle(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles,
                    std::vector<int> chosen);
    /// Over all of them.
    ClosestTriangle(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles);

    struct Hit {
        int triangle = -1;
        double distance = std::numeric_limits<double>::infinity();
    };
    /// The closest triangle, the one of least index where several are equally close. Logarithmic in the number of
    /// triangles for a point near them. @param near  one of the triangles that is near p, which saves time; or -1  @pre
    /// p is finite
    Hit closest(const Eigen::Vector3d& p, int near = -1) const;
    /// All within a distance, by index.
    std::vector<int> within(const Eigen::Vector3d& p, double distance) const;

    /// What is seen from its apex to either side of it, within an angle of its axis.
    struct Cone {
        Eigen::Vector3d apex, axis;  ///< axis: unit
        double cosine;               ///< of that angle, > 0
    };
    using Accept = std::function<bool(int triangle, const Eigen::Vector3d& point)>;
    /// The closest triangle whose point closest to the apex lies in the cone, off the apex, and is accepted; -1 where
    /// none is within reach.
    Hit closest_in_cone(const Cone& cone, double reach, const Accept& accept) const;

  private:
    struct Box {
        Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
        Eigen::Vector3d high = -low;
        void extend(const Box& other) {
            low = low.cwiseMin(other.low);
            high = high.cwiseMax(other.high);
        }
        double squared_distance(const Eigen::Vector3d& p) const {
            return (low - p).cwiseMax(p - high).cwiseMax(0).squaredNorm();
        }
    };
    struct Node {
        Box box;
        int first, last;  // range of chosen_
        int right = -1;   // second child, the first one follows this node; -1: leaf
    };
    using Coded = std::pair<std::uint64_t, int>;  // a triangle with its place on the curve
    int build(std::span<const Coded> coded, int first, int last);
    void descend(int node, const Eigen::Vector3d& p, double& squared, int& triangle) const;
    void look(int node, const Cone& cone, const Accept& accept, double& squared, int& triangle) const;

    std::span<const Eigen::Vector3d> points_;
    std::span<const Triangle> triangles_;
    std::vector<int> chosen_;
    std::vector<Node> nodes_;
};

}  // namespace gradus
