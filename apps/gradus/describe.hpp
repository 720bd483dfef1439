/// What is in a file, in lines for people and for machines, and what is wrong with it.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "cages.hpp"
#include "gradus/mesh/soup.hpp"
#include "json.hpp"

namespace gradus::app {

struct Description {
    std::string text;
    Json json;
};

/// @throws IoError, Failure naming the file
Description describe_patches(const std::string& path);
/// Why it has no limit surface, where it has none. @throws IoError
Description describe_cage(const std::string& path, const CageChoice& choice);
/// Of planar meshes their regions, holes and lines too. @param name  of the mesh, for the first line
Description describe_mesh(const std::string& name, const MeshData& data);

/// The box around some points.
struct Extent {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    void add(const Eigen::Vector3d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
    double diagonal() const { return (high - low).stableNorm(); }
    std::string text() const;
    Json json() const;
};

/// A line for each fault found, or one that there is none.
std::string text_of_faults(const std::vector<std::string>& found);

}  // namespace gradus::app
