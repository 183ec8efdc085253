// SPDX-License-Identifier: BSD-3-Clause
// A session and its connection to the server, as a page uses them: the whole state of the phone's
// page except its picture. Between the steps "request" and "decode" of the pipeline picture.
//
// No browser and no OpenGL here: PagePicture and WebViewer.cxx add these, and page.js adds the
// sockets and the clock.
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
  // clock: seconds of a steady clock, to measure how long parsing takes.
  explicit PageSession(std::function<double()> clock);

  ViewerSession& Session() { return this->Viewer; }
  const ViewerSession& Session() const { return this->Viewer; }
  ServerLine& Line() { return this->Connection; }

  // Takes the list of models as the server sent it. Errors: those of ParseModelList; then the old
  // list stays.
  Status SetModels(std::string_view json);
  // Selects a model as ViewerSession does. If it cannot be selected, the status says so.
  void SelectModel(const std::string& model);
  // Shows the view of a link (ViewLink.h). Errors in the link are reported in the status; the
  // link's model is opened nevertheless.
  void Follow(const std::string& link);
  // Sets how much memory is used in all, approximately (MemoryBudget). Before the first call: its
  // default.
  void SetMemory(std::size_t bytes);
  // taken: the memory that is used now. Call this often.
  void FollowMemory(std::size_t taken);
  std::size_t MemoryBytes() const { return this->Memory.Bytes(); }
  // Call this when the rest of the viewer has been loaded (parts.js). Until then only previews are
  // shown. Models whose preview has only points, that are lossless, or that have no levels, are not
  // shown until then: the server's answers for them wait here.
  void BecomeWhole();
  bool IsWhole() const { return this->Whole; }
  // Passes requests from the session to the connection, and answers back. Call this after every
  // input.
  void Exchange(double now);

  // A blob as it arrived, and its path at the server. The session has checked it as far as it can.
  // A page may store it for later.
  struct Arrival
  {
    std::string path;
    std::vector<std::uint8_t> bytes;
  };
  // Whether arrived blobs are offered for storing, and stored blobs searched; the default is false.
  void SetKeeps(bool keeps) { this->Keeps = keeps; }
  // Returns the next blob to store, if there is one.
  std::optional<Arrival> TakeArrival();
  // Returns the next search for blobs that the page may have stored: its number, then the blobs'
  // paths at the server, one per line; or "". Blobs that are not found are requested from the
  // server. While nothing arrives from the server, outstanding blobs are searched for, too. Then "
  // again" follows the number, because the page may have stored more since its first search.
  std::string TakeSearch();
  // Takes the blob `index` of the search; a damaged blob counts as not found. Ignored if the search
  // has ended, or if the blob is no longer needed.
  void Found(std::uint32_t search, std::size_t index, std::vector<std::uint8_t> bytes);
  // Ends a search. isKept: the user has stored the model for offline use. Then, while the server is
  // away, blobs that are not found fail instead of blocking others; they are tried again when the
  // server is back.
  void EndSearch(std::uint32_t search, bool isKept, double now);

  // Returns the measured distances:
  // [{"name","distance","height","horizontal","error","exact","waits","from","to"}]. from, to: the
  // ends on the screen, [x, y] in pixels, or null. height: along the model's up axis.
  std::string MeasurementsJson() const;
  // Marks the points of the surface that the views of these links look at. links: one per line. The
  // earlier marks are removed.
  void SetMarks(std::string_view links);
  // Returns [[x, y, isSeen]] for all marks in their order, in pixels. An entry is null if the link
  // has no view, if its view misses the surface, or if the mark is behind the eye. isSeen: nothing
  // hides the mark, and no section has cut it away.
  std::string MarksJson();
  // Writes what the user sees into an object; page.js describes the members. isInFlight: whether
  // the picture will still change because of data in flight.
  void Describe(JsonWriter& json, bool isInFlight) const;

private:
  struct Searched
  {
    SessionRequest request;
    bool isReported = false;
    std::vector<protocol::BlobId> found;
    bool isAgain = false;       // while nothing arrives from the server
    bool isOutstanding = false; // requested from the server, too
  };
  struct Mark
  {
    std::optional<CameraPlace> view;
    std::optional<Vec3> point; // on the surface with version `MarkedSurface`
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
  std::string Refusal; // error of the last selection
  bool Listed = false; // there is a list of models
  ModelDescription Open;
  std::uint32_t OpenRequest = 0; // later requests are for this model
  bool Whole = false;
  std::vector<ClientEvent> Waiting; // until the rest of the viewer is loaded
  bool Keeps = false;
  std::deque<Arrival> Arrivals;
  std::vector<Searched> Searches; // that have not ended
  bool IsAway = false;            // nothing arrives from the server
  bool Misses = false;            // something has failed because IsAway
  std::vector<Mark> Marks;
  // The version of the surface on which the marks were placed; nothing: they must be placed again.
  std::optional<std::uint64_t> MarkedSurface;
};

}
