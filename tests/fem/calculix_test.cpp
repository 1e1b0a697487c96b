// CalculiX's own cantilever of ten-node tetrahedra: every displacement of its printed result.

#include "fem/elastic_body.h"
#include "reference_problems.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

namespace retractor {
namespace {

    using namespace testing;

    std::filesystem::path shared_data()
    {
        const char* set = std::getenv("RETRACTOR_SHARED_DATA");
        return set != nullptr ? set : RETRACTOR_SHARED_DATA_DEFAULT;
    }

    std::vector<double> numbers(std::string line)
    {
        for (char& c : line)
            if (c == ',')
                c = ' ';
        std::istringstream stream(line);
        std::vector<double> values;
        for (double v = 0.0; stream >> v;)
            values.push_back(v);
        return values;
    }

    struct Deck {
        std::map<int, Vec3> nodes;
        std::vector<std::vector<int>> elements;
        std::map<std::string, std::vector<int>> sets;
        std::vector<std::string> boundary, loads;
        std::vector<double> elastic;
    };

    Deck read_deck(const std::filesystem::path& file)
    {
        Deck deck;
        std::ifstream stream(file);
        std::string line, section;
        std::vector<int> element;
        while (std::getline(stream, line)) {
            if (line.starts_with("**"))
                continue;
            if (line.starts_with("*")) {
                section = line;
                continue;
            }
            const std::vector<double> values = numbers(line);
            if (section.starts_with("*NODE,"))
                deck.nodes[static_cast<int>(values[0])] = { values[1], values[2], values.size() > 3 ? values[3] : 0.0 };
            else if (section.starts_with("*ELEMENT")) {
                for (const double v : values)
                    element.push_back(static_cast<int>(v));
                if (element.size() == 11) { // number and ten nodes, over two lines
                    deck.elements.emplace_back(element.begin() + 1, element.end());
                    element.clear();
                }
            } else if (section.starts_with("*NSET,NSET="))
                for (const double v : values)
                    deck.sets[section.substr(11)].push_back(static_cast<int>(v));
            else if (section.starts_with("*BOUNDARY"))
                deck.boundary.push_back(line);
            else if (section.starts_with("*CLOAD"))
                deck.loads.push_back(line);
            else if (section.starts_with("*ELASTIC"))
                deck.elastic = values;
        }
        return deck;
    }

    std::map<int, Vec3> read_displacements(const std::filesystem::path& file)
    {
        std::map<int, Vec3> all;
        std::ifstream stream(file);
        std::string line;
        bool inside = false;
        while (std::getline(stream, line)) {
            if (line.find("displacements") != std::string::npos)
                inside = true;
            else if (line.find("forces") != std::string::npos)
                break;
            else if (const auto v = numbers(line); inside && v.size() == 4)
                all[static_cast<int>(v[0])] = { v[1], v[2], v[3] };
        }
        return all;
    }

    /// "FIX,3,3" or "1,1,2": a node or a set, then numbers.
    std::pair<std::vector<int>, std::vector<double>> nodes_and_numbers(const Deck& deck, const std::string& line)
    {
        const auto comma = line.find(',');
        const std::string name = line.substr(0, comma);
        const auto set = deck.sets.find(name);
        return { set != deck.sets.end() ? set->second : std::vector<int> { std::stoi(name) },
            numbers(line.substr(comma + 1)) };
    }

    TEST(CalculiX, CantileverOfTenNodeTetrahedra)
    {
        const auto folder = shared_data() / "fem" / "calculix";
        if (!std::filesystem::exists(folder / "beam10p.inp"))
            GTEST_SKIP() << "no reference file " << folder / "beam10p.inp"
                         << ": set RETRACTOR_SHARED_DATA";
        const Deck deck = read_deck(folder / "beam10p.inp");
        ASSERT_EQ(deck.elements.size(), 31U);
        std::map<int, VertexId> id;
        TetMesh mesh;
        mesh.nodes_per_tet = 10;
        mesh.vertices.resize(static_cast<Eigen::Index>(deck.nodes.size()), 3);
        for (const auto& [number, p] : deck.nodes) {
            const auto v = static_cast<VertexId>(id.size());
            mesh.vertices.row(v) = p.transpose();
            id[number] = v;
        }
        // CalculiX orders the midpoints 12, 23, 13, 14, 24, 34: as we do.
        for (const auto& element : deck.elements) {
            for (const int number : element)
                mesh.nodes.push_back(id.at(number));
            mesh.labels.push_back(1);
        }
        std::vector<std::uint8_t> prescribed(3 * mesh.vertex_count(), 0);
        for (const std::string& line : deck.boundary) {
            const auto [nodes, values] = nodes_and_numbers(deck, line);
            for (const int number : nodes)
                for (int axis = static_cast<int>(values[0]); axis <= static_cast<int>(values[1]); ++axis)
                    prescribed[static_cast<std::size_t>(3 * id.at(number) + axis - 1)] = 1;
        }
        Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        for (const std::string& line : deck.loads) {
            const auto [nodes, values] = nodes_and_numbers(deck, line);
            for (const int number : nodes)
                loads[3 * id.at(number) + static_cast<int>(values[0]) - 1] += values[1];
        }
        ElasticBody body(mesh, Elasticity::linear, uniform(mesh, material(deck.elastic[0], deck.elastic[1])));
        const Eigen::VectorXd u = solve_linear(body, prescribed, Eigen::VectorXd::Zero(loads.size()), loads);
        const auto reference = read_displacements(folder / "beam10p.dat.ref");
        ASSERT_EQ(reference.size(), deck.nodes.size());
        constexpr double kLargest = 0.0877863;
        constexpr double kTol = 1e-6 * kLargest; // the file prints seven digits
        for (const auto& [number, expected] : reference)
            EXPECT_LE((u.segment<3>(3 * id.at(number)) - expected).cwiseAbs().maxCoeff(), kTol) << "node " << number;
    }

} // namespace
} // namespace retractor
