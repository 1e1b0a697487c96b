#include "tests/verification/framework/nodal_element.h"

#include <map>
#include <utility>

namespace retractor::verification {

std::vector<fem::AveragingDomain> nodal_domains(
    const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law_of_element, const std::vector<double>& /*volume*/)
{
    std::map<std::pair<VertexId, std::int32_t>, std::vector<TetId>> around; // by node and law
    for (std::size_t t = 0; t < mesh.tet_count(); ++t)
        for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
            around[{ v, law_of_element[t] }].push_back(static_cast<TetId>(t));
    constexpr double kPart = 0.25; // an element has four nodes
    std::vector<fem::AveragingDomain> domains;
    for (auto& [node_and_law, tets] : around)
        domains.push_back(
            { .law = node_and_law.second, .part = kPart, .tets = std::move(tets), .patch = node_and_law.first });
    return domains;
}

} // namespace retractor::verification
