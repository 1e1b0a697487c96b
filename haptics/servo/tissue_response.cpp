#include "haptics/servo/tissue_response.h"

namespace retractor::haptics {

TissueResponse::~TissueResponse() = default;

} // namespace retractor::haptics
