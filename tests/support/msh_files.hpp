/// Binary files of Gmsh, which are only read.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "support/bytes.hpp"

namespace support {

/// A square of two triangles and a quadrilateral beside it, in two surfaces, with a line, and values on all.
inline std::string binary_msh(int version, bool big) {
    std::string bytes = std::string("$MeshFormat\n") + (version == 2 ? "2.2" : "4.1") + " 1 8\n";
    const auto i4 = [&](std::int32_t i) { put(bytes, i, big); };
    const auto i8 = [&](std::uint64_t i) { put(bytes, i, big); };
    const auto real = [&](double r) { put(bytes, r, big); };
    const double points[6][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
    i4(1);
    bytes += "\n$EndMeshFormat\n";
    if (version == 2) {
        bytes += "$Nodes\n6\n";
        for (int n = 0; n < 6; ++n) {
            i4(10 * (n + 1));
            for (const double x : points[n]) real(x);
        }
        bytes += "\n$EndNodes\n$Elements\n4\n";
        for (const int i : {1, 1, 2, 7, 1, 1, 10, 20}) i4(i);
        for (const int i : {2, 2, 2, 8, 5, 1, 10, 20, 30, 9, 5, 1, 10, 30, 40}) i4(i);
        for (const int i : {3, 1, 2, 11, 0, 2, 20, 50, 60, 30}) i4(i);
    } else {
        bytes += "$Entities\n";
        for (const int n : {1, 1, 2, 0}) i8(static_cast<std::uint64_t>(n));
        i4(1);
        for (int k = 0; k < 3; ++k) real(0);
        i8(0);
        // A curve, then the surfaces; the first of these is in two physical groups.
        for (const auto& [tag, grouped] : {std::pair(1, false), {1, true}, {2, false}}) {
            i4(tag);
            for (int k = 0; k < 6; ++k) real(0);
            i8(grouped ? 2 : 0);
            if (grouped) i4(5), i4(77);
            i8(1);
            i4(1);
        }
        bytes += "\n$EndEntities\n$Nodes\n";
        for (const int n : {2, 6, 10, 60}) i8(static_cast<std::uint64_t>(n));
        for (const int i : {2, 1, 1}) i4(i);
        i8(4);
        for (std::uint64_t n = 1; n <= 4; ++n) i8(10 * n);
        for (int n = 0; n < 4; ++n) {
            for (const double x : points[n]) real(x);
            real(0.5), real(0.25);
        }
        for (const int i : {1, 2, 0}) i4(i);
        i8(2);
        i8(50), i8(60);
        for (int n = 4; n < 6; ++n)
            for (const double x : points[n]) real(x);
        bytes += "\n$EndNodes\n$Elements\n";
        for (const int n : {3, 4, 7, 11}) i8(static_cast<std::uint64_t>(n));
        for (const int i : {1, 1, 1}) i4(i);
        for (const int n : {1, 7, 10, 20}) i8(static_cast<std::uint64_t>(n));
        for (const int i : {2, 1, 2}) i4(i);
        for (const int n : {2, 8, 10, 20, 30, 9, 10, 30, 40}) i8(static_cast<std::uint64_t>(n));
        for (const int i : {2, 2, 3}) i4(i);
        for (const int n : {1, 11, 20, 50, 60, 30}) i8(static_cast<std::uint64_t>(n));
    }
    bytes +=
        "\n$EndElements\n$Comments\nany $End or $Nodes\n$EndComments\n$NodeData\n1\n\"size\"\n1\n0.0\n3\n0\n1\n2\n";
    i4(30), real(0.75);
    i4(10), real(0.1);
    bytes += "\n$EndNodeData\n$ElementData\n1\n\"flow\"\n1\n0.0\n3\n0\n3\n2\n";
    i4(7), real(9), real(9), real(9);
    i4(11), real(1), real(2), real(3);
    return bytes + "\n$EndElementData\n";
}

}  // namespace support
