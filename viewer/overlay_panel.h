#pragma once

#include "viewer/facts.h"
#include "viewer/session.h"

#include <string>

namespace lightgrid {

/// In units of the display's scale.
inline constexpr float panel_width = 288;

/// What a person is typing into the panel.
struct PanelText {
    std::string environment;  // path
};

/// The panel's controls and numbers, into the overlay's current window.
void lay_out_panel(Session& session, const Facts& facts, PanelText& text, Requests& requests);

}  // namespace lightgrid
