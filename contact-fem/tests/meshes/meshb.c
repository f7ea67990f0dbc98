/* Writes a Medit file in text anew in binary, in a version from 1 to 4, by the format's own library, libMeshb 7:
 * cc meshb.c -lMeshb.7 -lm -o meshb && ./meshb blocks.2.mesh blocks.2.v4.meshb 4 */
#include <libmeshb7.h>
#include <stdio.h>
#include <stdlib.h>

enum { KINDS = 6 };
static const int KEYWORDS[KINDS] = {GmfEdges, GmfTriangles, GmfTetrahedra, GmfEdgesP2, GmfTrianglesP2, GmfTetrahedraP2};

static void vertices(int64_t in, int64_t out, int dimension, int version)
{
    const int64_t count = GmfStatKwd(in, GmfVertices);
    GmfGotoKwd(in, GmfVertices);
    GmfSetKwd(out, GmfVertices, count);
    for (int64_t i = 0; i < count; i++) {
        double x[3] = {0, 0, 0};
        int label = 0;
        if (dimension == 2)
            GmfGetLin(in, GmfVertices, &x[0], &x[1], &label);
        else
            GmfGetLin(in, GmfVertices, &x[0], &x[1], &x[2], &label);
        const int64_t wide = label;
        if (dimension == 2 && version < 4)
            GmfSetLin(out, GmfVertices, x[0], x[1], label);
        else if (dimension == 2)
            GmfSetLin(out, GmfVertices, x[0], x[1], wide);
        else if (version < 4)
            GmfSetLin(out, GmfVertices, x[0], x[1], x[2], label);
        else
            GmfSetLin(out, GmfVertices, x[0], x[1], x[2], wide);
    }
}

/* The library takes as many of the numbers as a keyword has. */
static void elements(int64_t in, int64_t out, int keyword, int version)
{
    const int64_t count = GmfStatKwd(in, keyword);
    if (count == 0) return;
    GmfGotoKwd(in, keyword);
    GmfSetKwd(out, keyword, count);
    for (int64_t i = 0; i < count; i++) {
        int n[11] = {0};
        int64_t w[11];
        GmfGetLin(in, keyword, &n[0], &n[1], &n[2], &n[3], &n[4], &n[5], &n[6], &n[7], &n[8], &n[9], &n[10]);
        for (int k = 0; k < 11; k++) w[k] = n[k];
        if (version < 4)
            GmfSetLin(out, keyword, n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], n[9], n[10]);
        else
            GmfSetLin(out, keyword, w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], w[8], w[9], w[10]);
    }
}

int main(int arguments, char **argument)
{
    if (arguments != 4) return 2;
    const int version = atoi(argument[3]);
    int of_text, dimension;
    const int64_t in = GmfOpenMesh(argument[1], GmfRead, &of_text, &dimension);
    const int64_t out = in ? GmfOpenMesh(argument[2], GmfWrite, version, dimension) : 0;
    if (!in || !out || of_text < 2) {
        fprintf(stderr, "text with real numbers of 8 bytes is needed, and a version from 1 to 4\n");
        return 1;
    }
    vertices(in, out, dimension, version);
    for (int k = 0; k < KINDS; k++) elements(in, out, KEYWORDS[k], version);
    GmfCloseMesh(in);
    GmfCloseMesh(out);
    return 0;
}
