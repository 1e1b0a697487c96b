#include "planner/plan/bone_loads.h"

#include "fem/statics/elastic_problem.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/measures/bones/bone_forces.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/bones/joint_loads.h"
#include "planner/measures/bones/section_moments.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace retractor::planner {

namespace {

    /// Per node, whether an element of cartilage has this node.
    std::vector<std::uint8_t> cartilage_nodes(const mesh::TetMesh& wall, const mesh::LabelTable& table)
    {
        std::vector<std::uint8_t> flags(wall.vertex_count(), 0);
        const mesh::LabelFlags cartilage
            = mesh::flagged_labels(table, [](const mesh::LabelInfo& info) { return info.material == "cartilage"; });
        for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t)
            if (cartilage[wall.labels[static_cast<std::size_t>(t)]] != 0)
                for (const VertexId v : wall.tet(t))
                    flags[static_cast<std::size_t>(v)] = 1;
        return flags;
    }

} // namespace

std::vector<BoneMetrics> bone_metrics(const fem::ElasticProblem& problem, const SolverSettings& choice,
    const Eigen::VectorXd& displacement, const mesh::LabelTable& table, const AnatomicalFrame& frame)
{
    std::vector<BoneMetrics> bones;
    const std::vector<std::uint8_t> cartilage = cartilage_nodes(problem.mesh, table);
    const fem::TissueModel model { choice.elasticity, choice.element == ElementKind::locking_free };
    for (const Label label : fem::labels_met(problem.mesh)) {
        const mesh::LabelInfo* info = mesh::find_label(table, label);
        if (info == nullptr || !is_long_bone(info->name))
            continue;
        const std::vector<BoneForces> pieces
            = bone_forces(problem.mesh, problem.material_of_label, model, displacement, label);
        std::vector<BoneBar> bars;
        for (const BoneForces& piece : pieces)
            bars.push_back(section_moments(piece));
        if (std::ranges::all_of(bars, [](const BoneBar& bar) { return bar.sections.empty(); }))
            continue; // only a stump lies in the wall
        BoneMetrics bone = bone_limit(info->name, bars, frame);
        for (const BoneForces& piece : pieces) {
            if (!bone.spine_joint && is_rib(info->name))
                bone.spine_joint = spine_joint_load(piece, problem.mesh, problem.supports, displacement);
            if (!bone.cartilage)
                bone.cartilage = cartilage_load(piece, cartilage);
        }
        bones.push_back(std::move(bone));
    }
    return bones;
}

void measure_bones(PlannedField& field, const OpenedWound& wound, const SolverSettings& choice,
    const mesh::LabelTable& table, const AnatomicalFrame& frame)
{
    FieldMetrics& m = field.metrics;
    const bool in_equilibrium = is_usable(field.opening);
    m.bones_rough = choice.element == ElementKind::p1;
    const bool inverted = field.opening.status == fem::OpeningStatus::inverted && !in_equilibrium;
    if (inverted) {
        m.bones_message = "elements of the model are inside out"; // which says nothing of the patient
    } else if (!in_equilibrium) {
        m.bones_message = "the computation found no equilibrium";
    } else if (has_condensed_region(field)) {
        m.bones_message
            = "the tissue far from the lips was computed as linear, without the bones' turning; plan without "
              "a linear region";
    } else {
        try {
            m.bones = bone_metrics(field.problem, choice, displacement_at_nodes(field, wound), table, frame);
        } catch (const SolverError& error) {
            m.bones.clear();
            m.bones_message = error.what();
        }
    }
    set_attainable(m, in_equilibrium || inverted);
    if (m.attainable == Attainable::with_injury)
        remark(field.message, "attainable " + attainable_text(m));
}

} // namespace retractor::planner
