#include "ui/cli/doctor/solver_check.h"

#include "fem/linear_algebra/blas_threads.h"
#include "fem/statics/opening.h"
#include "mesh/base/job.h"

#include <cblas.h>
#include <cholmod.h>

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace retractor::ui::cli {

namespace {

    std::string library_of(const void* symbol)
    {
        Dl_info info {};
        return symbol != nullptr && ::dladdr(symbol, &info) != 0 && info.dli_fname != nullptr ? info.dli_fname : "";
    }

    double measured_gflops()
    {
        constexpr int n = 512;
        constexpr int kRounds = 4; // the first round warms up; the best of the others counts
        const std::vector<double> a(std::size_t { n } * n, 1.0 / 3.0), b(a);
        std::vector<double> c(a.size(), 0.0);
        double best = 0.0;
        for (int round = 0; round < kRounds; ++round) {
            const Stopwatch watch;
            cblas_dgemm(
                CblasColMajor, CblasNoTrans, CblasNoTrans, n, n, n, 1.0, a.data(), n, b.data(), n, 0.0, c.data(), n);
            if (round > 0)
                best = std::max(best, 2e-9 * n * n * n / watch.seconds());
        }
        // Every entry is n / 9. A wrong product has no rate.
        return std::abs(c[c.size() / 2] - n / 9.0) < 1e-9 ? best : 0.0;
    }

} // namespace

BlasCheck check_blas()
{
    // Finds the dgemm that CHOLMOD calls, as the dynamic linker finds it. The rates of libraries differ by a factor of
    // ten.
    BlasCheck check;
    check.library = library_of(::dlsym(RTLD_DEFAULT, "dgemm_"));
    check.description = fem::blas_description();
    check.is_openblas
        = !check.library.empty() && check.library == library_of(reinterpret_cast<const void*>(&openblas_get_config));
    const fem::ScopedBlasThreads one(1);
    check.gflops = measured_gflops();
    return check;
}

SolverCheck check_solver()
{
    constexpr int kCubes = 10;
    constexpr double kSpacing = 2.0, kStretch = 0.1; // mm
    const mesh::TetMesh bar = mesh::kuhn_box(kCubes, kCubes, kCubes, kSpacing);
    const double length = kCubes * kSpacing;
    fem::Supports supports;
    fem::HookPatch hook { .name = "end", .side = 1, .nodes = {}, .displacement = Vec3(0.0, 0.0, kStretch) };
    for (VertexId v = 0; v < static_cast<VertexId>(bar.vertex_count()); ++v) {
        if (bar.vertices(v, 2) == 0.0)
            supports.fixed.push_back(v);
        if (bar.vertices(v, 2) == length)
            hook.nodes.push_back(v);
    }
    // Without lateral contraction the answer is E A u / L, on any mesh.
    const fem::Material rubber { .name = "rubber",
        .youngs_modulus_MPa = 1.0,
        .poissons_ratio = 0.0,
        .density_tonne_per_mm3 = 1e-9,
        .source = "a check" };
    const std::vector<fem::Material> materials(2, rubber);
    const Stopwatch watch;
    fem::Opening opening(bar, materials, supports, { .elasticity = fem::Elasticity::linear, .tolerance = 1e-9 });
    const fem::OpeningResult result = opening.open(std::vector { hook });
    const double force = length * length * kStretch / length;
    std::array<int, 3> version {};
    cholmod_version(version.data());
    return { .cholmod_version
        = std::to_string(version[0]) + "." + std::to_string(version[1]) + "." + std::to_string(version[2]),
        .unknowns = static_cast<int>(3 * bar.vertex_count()),
        .seconds = watch.seconds(),
        .relative_error = std::abs(result.hook_forces_N.at(0).norm() / force - 1.0) };
}

} // namespace retractor::ui::cli
