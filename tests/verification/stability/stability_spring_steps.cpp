// Time steps at and beyond the bound of the spring model.

#include "tests/verification/stability/stability_families.h"

#include "fem/springs/edge_springs.h"
#include "tests/verification/framework/spring_dynamics.h"
#include "tests/verification/framework/stability.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace retractor::verification {

namespace {

    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

    struct Springs {
        mesh::TetMesh mesh = mesh::kuhn_box(4, 4, 4, 2.0);
        std::vector<fem::Material> materials
            = std::vector<fem::Material>(2, { "tissue", 0.04, 0.45, 1e-9, "verification" });
        fem::SpringNetwork network { mesh::CutSession { mesh }, materials };
        Springs()
        {
            std::vector<VertexId> bottom;
            for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
                if (mesh.vertices(v, 2) < 1e-9)
                    bottom.push_back(v);
            network.fix(bottom);
        }
    };

    std::string step_text(const StabilityBound& bound)
    {
        std::array<char, 96> text {};
        (void)std::snprintf(text.data(), text.size(), "bound %.4g us", 1e6 * bound.stable_step);
        return text.data();
    }

    /// Springs that are plucked and swing without damping: the motion must stay bounded.
    void swing(StabilityRow& row, double share)
    {
        Springs springs;
        SpringDynamics dynamics(springs.network, springs.materials, 0.0);
        const Eigen::Index n = dynamics.displacement().size();
        Eigen::VectorXd plucked(n);
        for (Eigen::Index i = 0; i < n; ++i)
            plucked[i] = 1e-3 * std::sin(1.0 + 12.9898 * static_cast<double>(i)); // mm, all frequencies
        dynamics.set_state(plucked, Eigen::VectorXd::Zero(n));
        const double dt = share * dynamics.bound().stable_step;
        double most = 0.0;
        constexpr int kSteps = 3000;
        for (int i = 0; i < kSteps; ++i) {
            dynamics.step(dt);
            most = std::max(most, dynamics.displacement().cwiseAbs().maxCoeff());
        }
        row.quantity = "largest excursion over the pluck, after 3,000 steps";
        row.error = most / plucked.cwiseAbs().maxCoeff();
        row.bound = 20.0; // many modes superpose; an unstable step grows by powers of ten
        row.residual = 0.0; // no system is solved
        row.unconditioned = Unconditioned::explicit_steps;
        row.reason = step_text(dynamics.bound());
    }

    void step_by(StabilityRow& row, const std::function<double(const StabilityBound&)>& dt)
    {
        Springs springs;
        SpringDynamics dynamics(springs.network, springs.materials, 0.0);
        row.unconditioned = Unconditioned::explicit_steps;
        dynamics.step(dt(dynamics.bound()));
        row.residual = row.error = 0.0;
    }

} // namespace

StabilityCase spring_step_case()
{
    return { "time steps of springs", "up to the bound the motion stays bounded; beyond it the step is refused",
        [](const Job&) {
            std::vector<StabilityRow> rows;
            for (const auto& [name, share] : { std::pair { "half the bound", 0.5 },
                     std::pair { "0.99 of the bound", 0.99 }, std::pair { "the bound itself", 1.0 } })
                rows.push_back(attempt(std::string("time step: ") + name, "springs, explicit",
                    [s = share](StabilityRow& row) { swing(row, s); }));
            using Bound = const StabilityBound&;
            const auto refused = [&](const char* name, const std::function<double(Bound)>& dt) {
                rows.push_back(expect_refusal(std::string("time step: ") + name, "springs, explicit",
                    "where the explicit scheme is stable", [&](StabilityRow& row) { step_by(row, dt); }));
            };
            refused("1.01 of the bound", [](Bound b) { return 1.01 * b.stable_step; });
            refused("ten times the bound", [](Bound b) { return 10.0 * b.stable_step; });
            refused("NaN", [](Bound) { return kNan; });
            refused("zero", [](Bound) { return 0.0; });
            refused("negative", [](Bound b) { return -b.stable_step; });
            return rows;
        } };
}

} // namespace retractor::verification
