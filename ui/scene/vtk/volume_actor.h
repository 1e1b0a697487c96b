#pragma once
// Makes VTK volume renderings of CT volumes, prepared once and kept.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <vtkSmartPointer.h>

#include <memory>

class vtkVolume;

namespace retractor::ui {

/// The volumes of the views of one window. A volume with the same image, mask and opacity is not built again. sweep()
/// drops the volumes that no view has used since the last sweep().
class VolumeCache {
public:
    /// Records the part "volume rendering" in the ledger for every prepared image.
    explicit VolumeCache(const Job& job = {});
    ~VolumeCache();

    vtkSmartPointer<vtkVolume> volume(const VolumeItem& item);
    void sweep();
    /// Samples more coarsely while a camera moves.
    void set_interactive(bool interactive);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui
