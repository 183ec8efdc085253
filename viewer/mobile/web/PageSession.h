// SPDX-License-Identifier: BSD-3-Clause
// A session and its connection to the server, as a page uses them: all state of the phone's page
// except its picture. Between steps "request" and "decode" of the pipeline picture.
//
// No browser and no OpenGL here: PagePicture and WebViewer.cxx add these, page.js the sockets and
// the clock.
#pragma once

#include "filters/model/JsonWriter.h"
#include "viewer/client/ServerLine.h"
#include "viewer/session/MemoryBudget.h"
#include "viewer/session/ViewerSession.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

class PageSession
{
public:
  // clock: seconds of a steady clock, for parsing times.
  explicit PageSession(std::function<double()> clock);

  ViewerSession& Session() { return this->Viewer; }
  const ViewerSession& Session() const { return this->Viewer; }
  ServerLine& Line() { return this->Connection; }

  // The list of models as the server sent it. Errors: those of ParseModelList; the old list stays
  // then.
  Status SetModels(std::string_view json);
  // Selects a model as ViewerSession does; the status names a model that cannot be selected.
  void SelectModel(const std::string& model);
  // Shows the view of a link (ViewLink.h). Errors in the link are reported in the status; its model
  // opens all the same.
  void Follow(const std::string& link);
  // Takes at most about this much memory in all (MemoryBudget); at first its default.
  void SetMemory(std::size_t bytes);
  // The memory taken now.
  void FollowMemory(std::size_t taken);
  std::size_t MemoryBytes() const { return this->Memory.Bytes(); }
  // The rest of the viewer has been loaded (parts.js). Until then only previews are shown. Models
  // whose preview is points, that are lossless, or that have no levels, show nothing until then:
  // what the server sends for them waits here.
  void BecomeWhole();
  bool IsWhole() const { return this->Whole; }
  // Carries between session and line what either has for the other. Call after every input.
  void Exchange(double now);

  // A blob as it arrived, undamaged as far as the session has checked, and its path at the server:
  // a page may store it for later.
  struct Arrival
  {
    std::string path;
    std::vector<std::uint8_t> bytes;
  };
  // Whether arrivals are gathered and searches made; not at first.
  void SetKeeps(bool keeps) { this->Keeps = keeps; }
  // The next blob to store, or nothing.
  std::optional<Arrival> TakeArrival();
  // The next search for blobs that the page may have stored: its number and their paths at the
  // server, a line each; or "". Blobs that are not found are requested from the server. While
  // nothing arrives from the server, outstanding blobs are searched for, too; then " again" follows
  // the number, because the page may have stored more since its first search.
  std::string TakeSearch();
  // Takes the blob `index` of the search; a damaged one counts as not found. Ignored if the search
  // has ended, or if nobody wants the blob any more.
  void Found(std::uint32_t search, std::size_t index, std::vector<std::uint8_t> bytes);
  // isKept: the user has stored the model for offline use. Then blobs that are not found must not
  // block the others: they have failed until the server is back.
  void EndSearch(std::uint32_t search, bool isKept, double now);

  // The measured distances:
  // [{"name","distance","height","horizontal","error","exact","waits","from","to"}]. from, to: the
  // ends on the screen, [x, y] in pixels, or null; heights are along the model's up.
  std::string MeasurementsJson() const;
  // Marks the surface where the views of these links look at it, a line each; the earlier marks are
  // gone.
  void SetMarks(std::string_view links);
  // [[x, y, isSeen]] of all marks by their order, in pixels; null where a link has no view, its
  // view misses the surface, or the mark is behind the eye. isSeen: nothing hides it, and no
  // section has cut it away.
  std::string MarksJson();
  // Writes what the user sees into an object; page.js describes its members. isInFlight: whether
  // the picture will still change by what is in flight.
  void Describe(JsonWriter& json, bool isInFlight) const;

private:
  struct Searched
  {
    SessionRequest request;
    bool isReported = false;
    std::vector<protocol::BlobId> found;
    bool isAgain = false;       // while nothing comes from the server
    bool isOutstanding = false; // by the server too
  };
  struct Mark
  {
    std::optional<CameraPlace> view;
    std::optional<Vec3> point; // on the surface `MarkedSurface`
  };
  void PlaceMarks();
  bool Sees(const Vec3& point) const;
  void Send(double now);
  void Send(const SessionRequest& request, double now);
  Searched* FindSearch(std::uint32_t id);
  void FollowTrouble();
  void SearchOutstanding();
  void Receive(ClientEvent event);
  void Take(const ClientEvent& event);
  bool NeedsSecondPart() const;
  std::string Staleness() const;

  MemoryBudget Memory;
  ViewerSession Viewer;
  ServerLine Connection;
  std::string Refusal; // of the last selection
  bool Listed = false; // there is a list of models
  ModelDescription Open;
  std::uint32_t OpenRequest = 0; // all later ones are for that model
  bool Whole = false;
  std::vector<ClientEvent> Waiting; // for the rest of the viewer
  bool Keeps = false;
  std::deque<Arrival> Arrivals;
  std::vector<Searched> Searches; // that have not ended
  bool IsAway = false;            // nothing comes from the server
  bool Misses = false;            // something has failed for this reason
  std::vector<Mark> Marks;
  // Version of the surface of the marks; nothing: marks must be placed again.
  std::optional<std::uint64_t> MarkedSurface;
};

}
