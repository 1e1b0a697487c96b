#pragma once
// Proposes ports for thoracoscopy: a scope and two instruments through intercostal spaces of one side. Units mm,
// degrees; frame patient LPS.

#include "mesh/base/job.h"
#include "planner/case/patient.h"
#include "planner/ports/port_scene.h"

#include <array>
#include <string>
#include <vector>

namespace retractor::planner {

/// Angle between two instruments at the target that lets them work best (Hanna, Shimi, Cuschieri 1997, Ann Surg
/// 226:333), and the range in which a proposal lies (ours).
inline constexpr double kBestBetweenDeg = 60.0, kLeastBetweenDeg = 30.0, kMostBetweenDeg = 90.0;
/// Distance between two ports on the skin, and between two shafts anywhere (ours).
inline constexpr double kPortsApartMm = 50.0, kShaftsApartMm = 5.0;

/// A place for a trocar in an intercostal space.
struct Port {
    bool left = true;
    int space = 0;
    double angle_deg = 0.0; ///< round the chest, see RibLine
    Vec3 skin = Vec3::Zero();
    double wall_mm = 0.0; ///< thickness of the wall there
};

/// "right 4th space, anterior axillary line".
std::string place_in_words(const Port& port);

struct PortRequest {
    TargetSpec target;
    bool left = false;
    Optics optics {};
    PortSizes sizes {};
    int highest_space = 3, lowest_space = 8;
    double from_deg = 70.0, to_deg = 160.0; ///< from the posterior axillary line to beside the sternum
    std::vector<std::string> aside {}; ///< organs held aside besides the usual ones
};

/// One proposal. Shares are of what the best of all scopes that were tried would see of the target alone.
struct PortPlan {
    Port scope;
    ScopeView view;
    Vec3 middle = Vec3::Zero(); ///< of the target's surface, where the instruments work
    std::array<Port, 2> instruments {};
    double seen = 0.0; ///< by the scope
    double worked_on = 0.0; ///< seen, and reached by both instruments
    std::array<double, 2> working_length_mm {}; ///< from the skin to the target's middle
    double between_deg = 0.0; ///< between the instruments, at the target's middle
    std::array<double, 2> from_view_deg {}; ///< between the view and each instrument, there
    double nearest_shafts_mm = 0.0; ///< smallest distance between surfaces of scope and shafts, inside and outside
    double points = 0.0; ///< 0 to 100, by which proposals are ranked
};

struct PortSearch {
    std::size_t ports = 0; ///< places that were tried
    std::size_t scopes = 0, instruments = 0; ///< places from which anything is seen, or reached
    std::vector<PortPlan> found; ///< the best first, with different places of the scope
    double seconds = 0.0;
};

/// Tries places 10 degrees apart in each space.
/// @param count number of proposals
/// @throws InputError as PortScene does, on bad optics and spaces, and where no space of this side is found
PortSearch find_ports(Patient& patient, const PortRequest& request, std::size_t count, const Job& job = {});

} // namespace retractor::planner
