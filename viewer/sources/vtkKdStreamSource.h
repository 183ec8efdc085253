// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdStreamSource
 * @brief   reads a model of a server (kdstream-serve): any VTK program as its client
 *
 * Any part of the model, at any resolution: vtkKdModelSource tells what. Only what is asked for is
 * fetched. The connection stays open until the address changes; where it is lost, it is made anew.
 * Whenever the pipeline asks for information, the server is asked which model it has: one that was
 * replaced is opened anew.
 *
 * A region needs the boxes of all partitions, about 40 bytes each. For the same reason the bounds
 * of partitions are told only where BoundsOfPartitions is on.
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
   * The name of the model; empty, the default: the only one that the server has.
   */
  vtkSetMacro(ModelId, std::string);
  vtkGetMacro(ModelId, std::string);
  ///@}

  ///@{
  /**
   * What the server gives to its guests. Default none.
   */
  vtkSetMacro(Token, std::string);
  vtkGetMacro(Token, std::string);
  ///@}

  ///@{
  /**
   * A PEM file of those whose word is taken for the server's certificate; empty, the default: those
   * that the system trusts.
   */
  vtkSetMacro(CertificateAuthorities, std::string);
  vtkGetMacro(CertificateAuthorities, std::string);
  ///@}

  ///@{
  /**
   * A folder for what has come, so that it need not be fetched again, with or without the server;
   * empty, the default: nothing is kept. CacheSize: its bytes at most; default 10 GiB.
   */
  vtkSetMacro(CacheFolder, std::string);
  vtkGetMacro(CacheFolder, std::string);
  vtkSetMacro(CacheSize, vtkTypeUInt64);
  vtkGetMacro(CacheSize, vtkTypeUInt64);
  ///@}

  ///@{
  /**
   * After so many seconds in which nothing comes a read is given up, 1 to 3600. Default 60.
   */
  virtual void SetTimeout(int value);
  vtkGetMacro(Timeout, int);
  ///@}

  ///@{
  /**
   * Whether the boxes of all partitions are fetched, and told in COMPOSITE_DATA_META_DATA. Default
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
  std::shared_ptr<const kdstream::ServerAddress> ConnectedTo; // of that
};

#endif
