#include "ui/cli/doctor/doctor_checks.h"

#include "datasets/io/format_check.h"
#include "haptics/device/hd_diagnosis.h"
#include "mesh/base/error.h"
#include "mesh/base/memory.h"
#include "mesh/base/text_format.h"
#include "ui/cli/doctor/solver_check.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include <sched.h>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    std::string rounded(double value, const char* unit, int digits = 1)
    {
        return formatted("%.*f %s", digits, value, unit);
    }

    Finding check_cores()
    {
        Finding finding { .topic = "machine", .name = "cores" };
        cpu_set_t allowed;
        CPU_ZERO(&allowed);
        const int usable = ::sched_getaffinity(0, sizeof(allowed), &allowed) == 0
            ? CPU_COUNT(&allowed)
            : static_cast<int>(std::thread::hardware_concurrency());
        finding.found = std::to_string(usable) + " usable";
        // A container may have many cores but only a share of their time.
        std::ifstream limits("/sys/fs/cgroup/cpu.max");
        double granted = 0.0, period = 0.0;
        if (limits >> granted >> period && period > 0.0) {
            finding.found += ", time for " + rounded(granted / period, "of them");
            if (granted / period < usable - 0.5) {
                finding.health = Health::warning;
                finding.advice = "give --threads " + std::to_string(std::max(1, static_cast<int>(granted / period)));
            }
        }
        if (usable == 1) {
            finding.health = Health::warning;
            finding.advice = "approaches are planned one after the other; two cores halve the time";
        }
        return finding;
    }

    Finding check_memory()
    {
        constexpr double kEnoughGiB = 4.0; // a whole chest of 256 x 256 x 124 voxels, two approaches at a time
        constexpr double kLeastGiB = 1.0; // a small phantom
        Finding finding { .topic = "machine", .name = "memory", .essential = true };
        const Memory memory = memory_of_machine();
        finding.found = rounded(memory.available.value_or(0.0) / kGiB, "GiB") + " of "
            + rounded(memory.total.value_or(0.0) / kGiB, "GiB") + " available";
        if (memory.left_in_container)
            finding.found += ", " + rounded(*memory.left_in_container / kGiB, "GiB") + " within this container's limit";
        const double available = available_memory().value_or(0.0);
        if (available < kEnoughGiB * kGiB) {
            finding.health = available < kLeastGiB * kGiB ? Health::missing : Health::warning;
            finding.advice = "a whole chest wants 4 GiB: close other programs, or import a coarser CT";
        }
        return finding;
    }

    Finding check_instructions()
    {
        Finding finding { .topic = "machine", .name = "instructions" };
#if defined(__x86_64__)
        const std::array<std::pair<const char*, bool>, 4> sets { { { "AVX", __builtin_cpu_supports("avx") != 0 },
            { "AVX2", __builtin_cpu_supports("avx2") != 0 }, { "FMA", __builtin_cpu_supports("fma") != 0 },
            { "AVX-512", __builtin_cpu_supports("avx512f") != 0 } } };
        for (const auto& [name, there] : sets)
            if (there)
                finding.found += (finding.found.empty() ? "" : ", ") + std::string(name);
        if (!sets[1].second) {
            finding.health = Health::warning;
            finding.found += finding.found.empty() ? "SSE2 only" : "";
            finding.advice = "factorisation and rays are several times slower without AVX2";
        }
#else
        finding.found = "not an x86-64 processor: OpenBLAS and Embree choose by themselves";
#endif
        return finding;
    }

    Finding check_room()
    {
        constexpr double kEnoughGiB = 2.0; // a case with a full-resolution CT, its meshes and pictures
        Finding finding { .topic = "machine", .name = "room for files" };
        try {
            const fs::path folder = fs::temp_directory_path();
            const double available = static_cast<double>(fs::space(folder).available) / kGiB;
            finding.found = rounded(available, "GiB") + " free in " + folder.string();
            if (available < kEnoughGiB) {
                finding.health = Health::warning;
                finding.advice = "set TMPDIR to a folder with 2 GiB free";
            }
        } catch (const fs::filesystem_error& error) {
            finding.health = Health::warning;
            finding.found = error.what();
            finding.advice = "set TMPDIR to a folder that exists";
        }
        return finding;
    }

    Finding check_product()
    {
        constexpr double kReferenceGflops = 5.0; // per core; the reference BLAS is slower
        const BlasCheck blas = check_blas();
        Finding finding { .topic = "solver", .name = "BLAS" };
        finding.found
            = blas.library + ": " + rounded(blas.gflops, "GFlop/s on one core") + " (" + blas.description + ")";
        if (!blas.is_openblas || blas.gflops < kReferenceGflops) {
            finding.health = blas.gflops > 0.0 ? Health::warning : Health::missing;
            finding.advice = blas.is_openblas ? "this is slow for OpenBLAS: is the machine busy?"
                                              : "this is not OpenBLAS and ten times slower: apt install libopenblas0";
        }
        return finding;
    }

    Finding check_factorisation()
    {
        constexpr double kTolerance = 1e-6; // the answer is exact except for the solver's own tolerance of 1e-9
        Finding finding { .topic = "solver", .name = "sparse solver", .essential = true };
        try {
            const SolverCheck solver = check_solver();
            finding.found = formatted("CHOLMOD %s: %d unknowns in %.0f ms, error %.0e", solver.cholmod_version.c_str(),
                solver.unknowns, 1e3 * solver.seconds, solver.relative_error);
            if (!(solver.relative_error < kTolerance)) {
                finding.health = Health::missing;
                finding.advice = "the answer is wrong: reinstall libcholmod3, libmetis5 and libopenblas0";
            }
        } catch (const Error& error) {
            finding.health = Health::missing;
            finding.found = error.what();
            finding.advice = "reinstall libcholmod3, libmetis5 and libopenblas0";
        }
        return finding;
    }

} // namespace

std::string to_string(Health health)
{
    return health == Health::ok ? "ok" : health == Health::warning ? "warning" : "missing";
}

std::vector<Finding> check_machine() { return { check_cores(), check_memory(), check_instructions(), check_room() }; }

std::vector<Finding> check_linear_algebra() { return { check_product(), check_factorisation() }; }

std::vector<Finding> check_images()
{
    std::vector<Finding> findings {
        { .topic = "images", .name = "libraries", .found = datasets::image_library_versions() }
    };
    std::error_code error;
    const fs::path folder = fs::temp_directory_path(error);
    for (const datasets::FormatCheck& format : datasets::check_formats(error ? fs::path(".") : folder)) {
        Finding finding { .topic = "images", .name = format.format, .found = "read without loss" };
        finding.essential = format.format == "DICOM uncompressed" || format.format == "NRRD";
        if (!format.works) {
            finding.health = Health::missing;
            finding.found = format.problem;
            finding.advice = "reinstall libvtkdicom0.8, libgdcm3.0 and libinsighttoolkit5.2, or convert such files";
        }
        findings.push_back(std::move(finding));
    }
    return findings;
}

std::vector<Finding> check_devices()
{
    std::vector<Finding> findings;
    for (const haptics::HdFinding& hd : haptics::diagnose_hd())
        findings.push_back({ .topic = "devices",
            .name = "Touch " + hd.name,
            .health = hd.ok ? Health::ok : Health::missing,
            .found = hd.found,
            .advice = hd.advice });
    return findings;
}

} // namespace retractor::ui::cli
