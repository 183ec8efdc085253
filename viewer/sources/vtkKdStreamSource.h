// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdStreamSource
 * @brief   reads a model from a server (kdstream-serve): any VTK program can be its client
 *
 * Reads any part of the model, at any resolution: see vtkKdModelSource. Only what is needed is
 * fetched. The connection stays open until the URL changes; a lost connection is opened again.
 * Whenever the pipeline asks for information, the server is asked which version of the model it
 * has: a replaced model is opened again.
 *
 * A region needs the boxes of all partitions, about 40 bytes each. For the same reason the output
 * information has the bounds of partitions only if BoundsOfPartitions is on.
 *
 * @sa vtkKdStoreReader vtkKdStreamActor vtkKdTextureReader
 */
#ifndef vtkKdStreamSource_h
#define vtkKdStreamSource_h

#include "vtkKdModelSource.h"

namespace kdstream
{
class RemoteModel;
struct ServerAddress;
}

class VTKKDSTREAMVIEWERSOURCES_EXPORT vtkKdStreamSource : public vtkKdModelSource
{
public:
  static vtkKdStreamSource* New();
  vtkTypeMacro(vtkKdStreamSource, vtkKdModelSource);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The server: http://HOST:PORT or https://HOST:PORT.
   */
  vtkSetMacro(Url, std::string);
  vtkGetMacro(Url, std::string);
  ///@}

  ///@{
  /**
   * The name of the model; empty, the default: the only model that the server has.
   */
  vtkSetMacro(ModelId, std::string);
  vtkGetMacro(ModelId, std::string);
  ///@}

  ///@{
  /**
   * The token that the server requires. Default none.
   */
  vtkSetMacro(Token, std::string);
  vtkGetMacro(Token, std::string);
  ///@}

  ///@{
  /**
   * A PEM file of certificate authorities to trust; empty, the default: those of the system.
   */
  vtkSetMacro(CertificateAuthorities, std::string);
  vtkGetMacro(CertificateAuthorities, std::string);
  ///@}

  ///@{
  /**
   * A folder for a cache, so that blobs need not be fetched again, with or without the server;
   * empty, the default: no cache. CacheSize: its maximum size in bytes; default 10 GiB.
   */
  vtkSetMacro(CacheFolder, std::string);
  vtkGetMacro(CacheFolder, std::string);
  vtkSetMacro(CacheSize, vtkTypeUInt64);
  vtkGetMacro(CacheSize, vtkTypeUInt64);
  ///@}

  ///@{
  /**
   * Connecting or reading fails if nothing arrives for this number of seconds, 1 to 3600 (at most
   * 30 for connecting). Default 60.
   */
  virtual void SetTimeout(int value);
  vtkGetMacro(Timeout, int);
  ///@}

  ///@{
  /**
   * Whether the boxes of all partitions are fetched, and put into COMPOSITE_DATA_META_DATA. Default
   * off.
   */
  vtkSetMacro(BoundsOfPartitions, bool);
  vtkGetMacro(BoundsOfPartitions, bool);
  vtkBooleanMacro(BoundsOfPartitions, bool);
  ///@}

protected:
  vtkKdStreamSource() = default;
  ~vtkKdStreamSource() override;

  std::shared_ptr<const kdstream::PieceSource> OpenModel(
    const kdstream::Execution& execution, kdstream::Error& error) override;
  void CloseModel() override;
  std::string ModelName() const override { return this->Url; }
  bool WantsBoxes() const override { return this->BoundsOfPartitions; }

private:
  vtkKdStreamSource(const vtkKdStreamSource&) = delete;
  void operator=(const vtkKdStreamSource&) = delete;

  kdstream::ServerAddress Address() const;

  std::string Url, ModelId, Token, CertificateAuthorities, CacheFolder;
  vtkTypeUInt64 CacheSize = vtkTypeUInt64{ 10 } << 30;
  int Timeout = 60;
  bool BoundsOfPartitions = false;
  std::shared_ptr<const kdstream::RemoteModel> Connected;
  std::shared_ptr<const kdstream::ServerAddress> ConnectedTo; // the address of Connected
};

#endif
