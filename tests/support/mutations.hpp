/// Readers of mesh files on damaged files.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "gradus/io/error.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/damage.hpp"
#include "support/files.hpp"

namespace support {

/// Reads damaged copies of the files, one after the other, from `path`: what is read is sound, what is refused is named.
/// @returns how many were refused
inline int count_refused(const std::string& path, const std::vector<std::string>& files, int mutations, std::mt19937_64& random) {
    int refused = 0;
    for (int mutation = 0; mutation < mutations; ++mutation) {
        spill(path, damaged(files[static_cast<std::size_t>(mutation) % files.size()], random));
        try {
            const gradus::MeshData data = gradus::read_mesh_data(path);
            const gradus::Diagnosis d = gradus::diagnose(data.soup);
            CHECK(d.out_of_range.empty());
            CHECK(d.bad_numbers.empty());
            for (const gradus::Field& field : data.point_fields)
                CHECK(field.values.size() == data.soup.points.size() * static_cast<std::size_t>(field.components));
            for (const gradus::Field& field : data.cell_fields)
                CHECK(field.values.size() == data.soup.triangles.size() * static_cast<std::size_t>(field.components));
        } catch (const gradus::IoError& error) {
            ++refused;
            CHECK(error.path() == path);
        }
    }
    return refused;
}

}  // namespace support
