#include "haptics/condensed/pad_stiffness.h"

#include "haptics/condensed/contact_solver.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <utility>

namespace retractor::haptics {

namespace {

    /// Contact nodes in a group; in a larger group fewer of the reached unknowns are shared.
    constexpr std::size_t kMiddles = 8;
    constexpr double kFacing = 0.2; // excludes the far side of a thin vessel

    const ContactNode& at(const TouchSurface& surface, std::int32_t s)
    {
        return surface.contact_nodes()[static_cast<std::size_t>(s)];
    }

    bool presses(const TouchSurface& surface, std::int32_t middle, std::int32_t s, double radius)
    {
        return (at(surface, s).point - at(surface, middle).point).norm() < radius
            && at(surface, s).normal.dot(at(surface, middle).normal) >= kFacing;
    }

    /// Breadth-first search from `start` over the contact nodes for which `inside` holds.
    template <class Inside>
    std::vector<std::int32_t> around(const TouchSurface& surface, std::int32_t start, const Inside& inside)
    {
        std::vector<std::int32_t> found { start };
        for (std::size_t i = 0; i < found.size(); ++i)
            for (const std::int32_t next : surface.contact_node_neighbours().of(static_cast<std::size_t>(found[i])))
                if (std::find(found.begin(), found.end(), next) == found.end() && inside(next))
                    found.push_back(next);
        return found;
    }

} // namespace

std::vector<PadGroup> pad_groups(const TouchSurface& surface, double radius)
{
    RETRACTOR_ASSERT(radius > 0.0);
    std::vector<PadGroup> groups;
    std::vector<std::uint8_t> grouped(surface.contact_nodes().size(), 0);
    for (std::int32_t seed = 0; seed < static_cast<std::int32_t>(grouped.size()); ++seed) {
        if (grouped[static_cast<std::size_t>(seed)] != 0)
            continue;
        PadGroup group;
        group.middles = around(surface, seed, [&](std::int32_t s) {
            return grouped[static_cast<std::size_t>(s)] == 0 && presses(surface, seed, s, radius);
        });
        group.middles.resize(std::min(group.middles.size(), kMiddles));
        for (const std::int32_t middle : group.middles) {
            grouped[static_cast<std::size_t>(middle)] = 1;
            for (const std::int32_t s :
                around(surface, middle, [&](std::int32_t next) { return presses(surface, middle, next, radius); }))
                if (std::find(group.pressed.begin(), group.pressed.end(), s) == group.pressed.end())
                    group.pressed.push_back(s);
        }
        groups.push_back(std::move(group));
    }
    return groups;
}

double pad_stiffness(const TouchSurface& surface, std::int32_t middle, double radius,
    const std::vector<std::int32_t>& pressed, const Eigen::MatrixXd& compliance)
{
    RETRACTOR_ASSERT(compliance.rows() == static_cast<Eigen::Index>(pressed.size()));
    RETRACTOR_ASSERT(compliance.cols() == compliance.rows());
    std::vector<Eigen::Index> under;
    for (std::size_t i = 0; i < pressed.size(); ++i)
        if (presses(surface, middle, pressed[i], radius))
            under.push_back(static_cast<Eigen::Index>(i));
    ContactSolver solver(under.size());
    for (std::size_t a = 0; a < under.size(); ++a) {
        const Vec3 from = at(surface, pressed[static_cast<std::size_t>(under[a])]).point - at(surface, middle).point;
        const double above = from.dot(at(surface, middle).normal);
        const double share = std::max(0.0, from.squaredNorm() - above * above) / (radius * radius),
                     s4 = share * share * share * share;
        solver.demand(a) = 1.0 - s4 * s4 * s4; // the same decrease as in FingertipSearch
        solver.pressing(a) = 1;
        for (std::size_t b = 0; b <= a; ++b)
            solver.compliance(a, b) = compliance(under[a], under[b]);
    }
    if (!solver.solve(under.size()))
        throw SolverError("no forces under a fingertip were found", "contact node " + std::to_string(middle));
    double sum = 0.0;
    for (std::size_t a = 0; a < under.size(); ++a)
        sum += solver.force(a);
    return sum;
}

} // namespace retractor::haptics
